#include "pbrt/lights/windowed_distribution.h"

#include "pbrt/core/check.h"

namespace lacquer {

namespace {

/// x in [low, high] where the increasing function `mass`, linear between multiples of 1/n, reaches `target`.
template <class Mass>
float InvertMass(double target, float low, float high, int n, const Mass& mass) {
    // Bisect over the grid lines inside of the interval, then solve the linear piece.
    int first = int(std::floor(low * float(n))), last = int(std::ceil(high * float(n)));
    double x0 = double(low), x1 = double(high), m0 = mass(x0), m1 = mass(x1);
    while (last - first > 1) {
        const int middle = (first + last) / 2;
        const double x = double(middle) / n, m = mass(x);
        if (m <= target) {
            first = middle;
            x0 = x;
            m0 = m;
        } else {
            last = middle;
            x1 = x;
            m1 = m;
        }
    }
    const double t = m1 > m0 ? std::clamp((target - m0) / (m1 - m0), 0.0, 1.0) : 0.5;
    return std::clamp(float(x0 + t * (x1 - x0)), low, high);
}

}  // namespace

WindowedDistribution::WindowedDistribution(std::span<const float> values, int nx, int ny)
    : nx_(nx), ny_(ny), values_(values.begin(), values.end()), table_(size_t(nx + 1) * size_t(ny + 1)) {
    LACQUER_CHECK(nx > 0 && ny > 0 && values.size() == size_t(nx) * size_t(ny));
    for (int y = 0; y < ny; ++y) {
        double row = 0;
        for (int x = 0; x < nx; ++x) {
            row += double(values_[size_t(y) * size_t(nx) + size_t(x)]);
            Table(x + 1, y + 1) = Table(x + 1, y) + row;
        }
    }
    const double cell = 1 / (double(nx) * double(ny));
    for (double& t : table_) t *= cell;
}

double WindowedDistribution::Sum(double x, double y) const {
    // The integral of a piecewise constant function is bilinear within each cell.
    const double gx = x * nx_, gy = y * ny_;
    const int ix = std::clamp(int(gx), 0, nx_ - 1), iy = std::clamp(int(gy), 0, ny_ - 1);
    const double dx = gx - ix, dy = gy - iy;
    return (1 - dy) * ((1 - dx) * Table(ix, iy) + dx * Table(ix + 1, iy)) +
           dy * ((1 - dx) * Table(ix, iy + 1) + dx * Table(ix + 1, iy + 1));
}

double WindowedDistribution::Integral(const Window& w) const {
    const double x0 = double(w.min.x), x1 = double(w.max.x), y0 = double(w.min.y), y1 = double(w.max.y);
    return std::max(0.0, (Sum(x1, y1) - Sum(x0, y1)) - (Sum(x1, y0) - Sum(x0, y0)));
}

float WindowedDistribution::Value(Point2 p) const {
    const int x = std::clamp(int(p.x * float(nx_)), 0, nx_ - 1),
              y = std::clamp(int(p.y * float(ny_)), 0, ny_ - 1);
    return values_[size_t(y) * size_t(nx_) + size_t(x)];
}

std::optional<Point2> WindowedDistribution::Sample(Point2 u, const Window& window, float* pdf) const {
    const double integral = Integral(window);
    if (!(integral > 0)) return std::nullopt;

    // Choose x by the mass of the window to its left.
    const double y0 = double(window.min.y), y1 = double(window.max.y);
    const double left = Sum(double(window.min.x), y1) - Sum(double(window.min.x), y0);
    const auto massLeftOf = [&](double x) { return Sum(x, y1) - Sum(x, y0) - left; };
    Point2 p;
    p.x = InvertMass(double(u.x) * integral, window.min.x, window.max.x, nx_, massLeftOf);

    // Choose y by the mass of the column of cells around x.
    const int column = std::clamp(int(p.x * float(nx_)), 0, nx_ - 1);
    const double c0 = double(column) / nx_, c1 = double(column + 1) / nx_;
    const double above = Sum(c1, y0) - Sum(c0, y0);
    const auto massAbove = [&](double y) { return Sum(c1, y) - Sum(c0, y) - above; };
    p.y = InvertMass(double(u.y) * massAbove(y1), window.min.y, window.max.y, ny_, massAbove);

    const float value = Value(p);
    if (!(value > 0)) return std::nullopt;
    *pdf = float(double(value) / integral);
    return p;
}

float WindowedDistribution::Pdf(Point2 p, const Window& window) const {
    if (!window.Contains(p)) return 0;
    const double integral = Integral(window);
    return integral > 0 ? float(double(Value(p)) / integral) : 0.f;
}

}  // namespace lacquer
