#include "pbrt/bxdfs/bilinear_warp.h"

#include "pbrt/core/check.h"

namespace lacquer {
namespace {

/// The cell of a coordinate in [0,1], and the place in it.
struct CellPosition {
    size_t cell;
    float t;
    CellPosition(float x, size_t numSamples) {
        const float scaled = std::clamp(x, 0.f, 1.f) * float(numSamples - 1);
        cell = std::min(size_t(scaled), numSamples - 2);
        t = scaled - float(cell);
    }
};

/// Integral from 0 to t of the line from a to b over [0,1], and t for a given integral.
float LineIntegral(float t, float a, float b) { return t * (a + 0.5f * t * (b - a)); }
float InvertLineIntegral(float y, float a, float b) {
    const float root = a + SafeSqrt(a * a + 2 * y * (b - a));
    return root > 0 ? std::clamp(2 * y / root, 0.f, 1.f) : 0.f;
}

}  // namespace

SliceBlend SliceBlend::Refined(std::span<const float> nodes, float value) const {
    const int n = int(nodes.size());
    SliceBlend refined;
    if (n == 1) return *this;
    const int i = FindInterval(n, [&](int k) { return nodes[size_t(k)] <= value; });
    const float a = nodes[size_t(i)], b = nodes[size_t(i) + 1];
    const float t = std::clamp((value - a) / (b - a), 0.f, 1.f);
    refined.count = 0;
    for (int k = 0; k < count; ++k)
        for (int side = 0; side < 2; ++side) {
            const float w = weight[k] * (side == 0 ? 1 - t : t);
            if (!(w > 0)) continue;
            LACQUER_DCHECK(refined.count < kMax);
            refined.slice[refined.count] = slice[k] * size_t(n) + size_t(i + side);
            refined.weight[refined.count++] = w;
        }
    return refined;
}

float BilinearTables::Evaluate(Point2 p, const SliceBlend& blend) const {
    const CellPosition x(p.x, columns_), y(p.y, rows_);
    const size_t corner = y.cell * columns_ + x.cell;
    float sum = 0;
    for (int k = 0; k < blend.count; ++k) {
        const float* v = &values_[blend.slice[k] * rows_ * columns_ + corner];
        sum += blend.weight[k] * Lerp(y.t, Lerp(x.t, v[0], v[1]), Lerp(x.t, v[columns_], v[columns_ + 1]));
    }
    return sum;
}

BilinearWarp::BilinearWarp(std::vector<float> values, size_t rows, size_t columns)
    : values_(std::move(values)), rows_(rows), columns_(columns) {
    const size_t size = rows * columns, numSlices = values_.size() / size;
    rowIntegrals_.resize(values_.size());
    marginals_.resize(numSlices * rows);
    for (size_t s = 0; s < numSlices; ++s) {
        const std::span<float> table = std::span(values_).subspan(s * size, size);
        bool any = false;
        for (float& v : table) any |= (v = std::max(v, 0.f)) > 0;
        if (!any) std::fill(table.begin(), table.end(), 1.f);
        // Trapezia along the rows, then over them; in double, so that the last one is 1.
        std::vector<double> row(size), over(rows);
        for (size_t y = 0; y < rows; ++y)
            for (size_t x = 1; x < columns; ++x)
                row[y * columns + x] = row[y * columns + x - 1] + 0.5 * (double(table[y * columns + x - 1]) +
                                                                         double(table[y * columns + x]));
        for (size_t y = 1; y < rows; ++y)
            over[y] = over[y - 1] + 0.5 * (row[y * columns - 1] + row[(y + 1) * columns - 1]);
        const double scale = 1 / over.back();
        for (float& v : table) v = float(double(v) * scale);
        for (size_t i = 0; i < size; ++i) rowIntegrals_[s * size + i] = float(row[i] * scale);
        for (size_t y = 0; y < rows; ++y) marginals_[s * rows + y] = float(over[y] * scale);
    }
}

float BilinearWarp::At(const std::vector<float>& table, size_t stride, size_t index,
                       const SliceBlend& blend) const {
    float sum = 0;
    for (int k = 0; k < blend.count; ++k) sum += blend.weight[k] * table[blend.slice[k] * stride + index];
    return sum;
}
float BilinearWarp::Value(size_t row, size_t column, const SliceBlend& blend) const {
    return At(values_, rows_ * columns_, row * columns_ + column, blend);
}
float BilinearWarp::RowIntegral(size_t row, size_t column, const SliceBlend& blend) const {
    return At(rowIntegrals_, rows_ * columns_, row * columns_ + column, blend);
}
float BilinearWarp::Marginal(size_t row, const SliceBlend& blend) const {
    return At(marginals_, rows_, row, blend);
}

BilinearWarp::Point BilinearWarp::Sample(Point2 u, const SliceBlend& blend) const {
    // The row, by the marginal density, which is linear from one row to the next.
    const float targetY = u.y * Marginal(rows_ - 1, blend);
    const size_t row =
        size_t(FindInterval(int(rows_), [&](int y) { return Marginal(size_t(y), blend) <= targetY; }));
    const float row0 = RowIntegral(row, columns_ - 1, blend),
                row1 = RowIntegral(row + 1, columns_ - 1, blend);
    const float y = InvertLineIntegral(targetY - Marginal(row, blend), row0, row1);

    // The column, in the row that is interpolated there.
    const float targetX = u.x * Lerp(y, row0, row1);
    const auto integral = [&](size_t column) {
        return Lerp(y, RowIntegral(row, column, blend), RowIntegral(row + 1, column, blend));
    };
    const size_t column =
        size_t(FindInterval(int(columns_), [&](int x) { return integral(size_t(x)) <= targetX; }));
    const float v0 = Lerp(y, Value(row, column, blend), Value(row + 1, column, blend));
    const float v1 = Lerp(y, Value(row, column + 1, blend), Value(row + 1, column + 1, blend));
    const float x = InvertLineIntegral(targetX - integral(column), v0, v1);
    return {{(float(column) + x) / float(columns_ - 1), (float(row) + y) / float(rows_ - 1)},
            Lerp(x, v0, v1) * Scale()};
}

BilinearWarp::Point BilinearWarp::Invert(Point2 p, const SliceBlend& blend) const {
    const CellPosition x(p.x, columns_), y(p.y, rows_);
    const float row0 = RowIntegral(y.cell, columns_ - 1, blend);
    const float row1 = RowIntegral(y.cell + 1, columns_ - 1, blend);
    const float v0 = Lerp(y.t, Value(y.cell, x.cell, blend), Value(y.cell + 1, x.cell, blend));
    const float v1 = Lerp(y.t, Value(y.cell, x.cell + 1, blend), Value(y.cell + 1, x.cell + 1, blend));
    const float before =
        Lerp(y.t, RowIntegral(y.cell, x.cell, blend), RowIntegral(y.cell + 1, x.cell, blend));
    const float inRow = Lerp(y.t, row0, row1);
    const float ux = inRow > 0 ? (before + LineIntegral(x.t, v0, v1)) / inRow : p.x;
    const float uy = (Marginal(y.cell, blend) + LineIntegral(y.t, row0, row1)) / Marginal(rows_ - 1, blend);
    return {{std::clamp(ux, 0.f, 1.f), std::clamp(uy, 0.f, 1.f)}, Lerp(x.t, v0, v1) * Scale()};
}

float BilinearWarp::Pdf(Point2 p, const SliceBlend& blend) const {
    const CellPosition x(p.x, columns_), y(p.y, rows_);
    return Scale() * Lerp(y.t, Lerp(x.t, Value(y.cell, x.cell, blend), Value(y.cell, x.cell + 1, blend)),
                          Lerp(x.t, Value(y.cell + 1, x.cell, blend), Value(y.cell + 1, x.cell + 1, blend)));
}

}  // namespace lacquer
