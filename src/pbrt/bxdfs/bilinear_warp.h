// Families of functions on the unit square, bilinear between samples, to look up and to draw from.
#pragma once

#include <span>
#include <vector>

#include "pbrt/core/vec.h"

namespace lacquer {

/// Which tables of a family are mixed, and how much of each: linear interpolation in up to three parameters.
struct SliceBlend {
    static constexpr int kMax = 8;
    int count = 1;
    size_t slice[kMax] = {0};
    float weight[kMax] = {1};

    /// The blend of a family with one parameter more, which runs faster than all others: `value` between the
    /// increasing `nodes`, constant beyond their ends.
    SliceBlend Refined(std::span<const float> nodes, float value) const;
};

/// Tables of one size, whose samples stand at equal steps from edge to edge of the square.
class BilinearTables {
  public:
    BilinearTables() = default;
    /// @param values  [slice][row][column], at least 2 rows and 2 columns; x goes with columns
    BilinearTables(std::vector<float> values, size_t rows, size_t columns)
        : values_(std::move(values)), rows_(rows), columns_(columns) {}
    float Evaluate(Point2 p, const SliceBlend& blend) const;

  private:
    std::vector<float> values_;
    size_t rows_ = 0, columns_ = 0;
};

/// The same as densities: each table is scaled to integrate to 1, so that their mixtures do. A marginal
/// density over rows and conditional ones within them, both piecewise linear.
class BilinearWarp {
  public:
    struct Point {
        Point2 p{0};
        float pdf = 0;  ///< at the drawn point
    };

    BilinearWarp() = default;
    /// As BilinearTables. Negative values count as 0; a table without positive ones is uniform.
    BilinearWarp(std::vector<float> values, size_t rows, size_t columns);
    /// A point of the square with the density of the blend, from a uniform u. Cost: two binary searches.
    Point Sample(Point2 u, const SliceBlend& blend) const;
    /// u with Sample(u) = p, and the density at p.
    Point Invert(Point2 p, const SliceBlend& blend) const;
    float Pdf(Point2 p, const SliceBlend& blend) const;

  private:
    float At(const std::vector<float>& table, size_t stride, size_t index, const SliceBlend& blend) const;
    float Value(size_t row, size_t column, const SliceBlend& blend) const;
    /// Integral over a row up to a column, in units of cells.
    float RowIntegral(size_t row, size_t column, const SliceBlend& blend) const;
    float Marginal(size_t row, const SliceBlend& blend) const;
    float Scale() const { return float((rows_ - 1) * (columns_ - 1)); }

    std::vector<float> values_, rowIntegrals_, marginals_;
    size_t rows_ = 0, columns_ = 0;
};

}  // namespace lacquer
