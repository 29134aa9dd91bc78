// A density on a grid, restricted to a rectangle that is known only when a sample is drawn.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "pbrt/core/vec.h"

namespace lacquer {

/// Rectangle in the unit square.
struct Window {
    Point2 min{0}, max{1};
    bool Contains(Point2 p) const { return p.x >= min.x && p.x <= max.x && p.y >= min.y && p.y <= max.y; }
};

/// Piecewise constant function on [0,1]^2 whose share inside any window is found in O(log n) by a summed-area
/// table [Crow 1984]; the marginal and the conditional distribution of the window are inverted by bisection.
class WindowedDistribution {
  public:
    /// @param values  not negative, finite, in rows (x fastest), nx * ny of them
    WindowedDistribution(std::span<const float> values, int nx, int ny);

    /// A point of the window with density proportional to the function. Empty if the function is zero there.
    std::optional<Point2> Sample(Point2 u, const Window& window, float* pdf) const;
    /// Density of Sample() at p, over the area of the unit square; 0 outside of the window.
    float Pdf(Point2 p, const Window& window) const;
    /// Integral of the function over a window.
    double Integral(const Window& window) const;

  private:
    double Sum(double x, double y) const;
    double& Table(int x, int y) { return table_[size_t(y) * size_t(nx_ + 1) + size_t(x)]; }
    double Table(int x, int y) const { return table_[size_t(y) * size_t(nx_ + 1) + size_t(x)]; }
    float Value(Point2 p) const;

    int nx_, ny_;
    std::vector<float> values_;
    std::vector<double> table_;  // (ny + 1) rows of nx + 1: sums over all cells to the left and above
};

}  // namespace lacquer
