#include "gaussfit/fit/slice_mixture.h"

#include <cmath>

namespace lacquer::gaussfit {

namespace {

constexpr double kTwoPi = 6.283185307179586;

/// The densities of a mixture's parts over the grid of a slice. They are products of a function of x and one
/// of y, so that a cell costs a multiplication.
class GridDensities {
  public:
    GridDensities(const Slice& slice, const SliceMixture& mixture) {
        for (int i = 0; i < mixture.count; ++i) {
            const SliceGaussian& g = mixture.parts[size_t(i)];
            const double scale = g.weight / (kTwoPi * std::sqrt(g.varianceX * g.varianceY));
            for (int column = 0; column < slice.columns; ++column) {
                const double d = slice.X(column) - g.meanX;
                byColumn_[size_t(i)].push_back(scale * std::exp(-0.5 * d * d / g.varianceX));
            }
            for (int row = 0; row < slice.rows; ++row) {
                const double y = slice.Y(row);
                byRow_[size_t(i)].push_back(std::exp(-0.5 * y * y / g.varianceY));
            }
        }
    }
    double At(int part, int column, int row) const {
        return byColumn_[size_t(part)][size_t(column)] * byRow_[size_t(part)][size_t(row)];
    }

  private:
    std::array<std::vector<double>, LobeTable::kMaxComponents> byColumn_, byRow_;
};

// Keeps logs and quotients finite where all parts underflow.
constexpr double kTinyDensity = 1e-280;

/// Sums of a part's share.
struct Share {
    double mass = 0, x = 0, xx = 0, yy = 0;
    void Add(double m, double atX, double atY) {
        mass += m;
        x += m * atX;
        xx += m * atX * atX;
        yy += m * atY * atY;
    }
    SliceGaussian Moments(const Slice& slice) const {
        SliceGaussian g;
        g.weight = mass;
        g.meanX = x / mass;
        // The mass of a cell is spread over it.
        g.varianceX = xx / mass - g.meanX * g.meanX + std::pow((slice.x1 - slice.x0) / slice.columns, 2) / 12;
        g.varianceY = yy / mass + std::pow(slice.y1 / slice.rows, 2) / 12;
        return g;
    }
};

}  // namespace

double SliceMixture::Pdf(double x, double y) const {
    double sum = 0;
    for (int i = 0; i < count; ++i) {
        const SliceGaussian& g = parts[size_t(i)];
        const double d = x - g.meanX;
        sum += g.weight / (kTwoPi * std::sqrt(g.varianceX * g.varianceY)) *
               std::exp(-0.5 * (d * d / g.varianceX + y * y / g.varianceY));
    }
    return sum;
}

SliceMixture MixtureOf(const LobeTable& table, const SlicePoint& point) {
    std::array<LobeShape<float>, LobeTable::kMaxComponents> shapes;
    std::array<float, LobeTable::kMaxComponents> weights;
    SliceMixture mixture;
    mixture.count = 0;
    if (!table.Find({float(point.alpha), float(point.eta), float(std::cos(point.theta))}, &shapes, &weights))
        return mixture;
    mixture.count = table.Get().model->numComponents;
    for (size_t i = 0; i < size_t(mixture.count); ++i)
        mixture.parts[i] = {double(weights[i]), double(shapes[i].mean),
                            1 / std::pow(double(shapes[i].l11), 2), 1 / std::pow(double(shapes[i].l22), 2)};
    return mixture;
}

double LogLikelihood(const Slice& slice, const SliceMixture& mixture) {
    const GridDensities densities(slice, mixture);
    double sum = 0;
    for (int row = 0; row < slice.rows; ++row)
        for (int column = 0; column < slice.columns; ++column) {
            const double mass = double(slice.At(column, row));
            if (mass == 0) continue;
            double density = kTinyDensity;
            for (int i = 0; i < mixture.count; ++i) density += densities.At(i, column, row);
            sum += mass * std::log(density);
        }
    return sum;
}

double Overlap(const Slice& slice, const SliceMixture& mixture) {
    const GridDensities densities(slice, mixture);
    // Both halves of y are in the mass of a cell.
    const double area = 2 * (slice.x1 - slice.x0) / slice.columns * slice.y1 / slice.rows;
    double sum = 0;
    for (int row = 0; row < slice.rows; ++row)
        for (int column = 0; column < slice.columns; ++column) {
            double density = 0;
            for (int i = 0; i < mixture.count; ++i) density += densities.At(i, column, row);
            sum += std::min(double(slice.At(column, row)), area * density);
        }
    return sum;
}

SliceMixture ShareOut(const Slice& slice, const SliceMixture& mixture) {
    const GridDensities densities(slice, mixture);
    Share first, second;
    for (int row = 0; row < slice.rows; ++row)
        for (int column = 0; column < slice.columns; ++column) {
            const double mass = double(slice.At(column, row));
            if (mass == 0) continue;
            double part = 1;
            if (mixture.count == 2) {
                const double a = densities.At(0, column, row), b = densities.At(1, column, row);
                part = (a + kTinyDensity) / (a + b + 2 * kTinyDensity);
                second.Add(mass * (1 - part), slice.X(column), slice.Y(row));
            }
            first.Add(mass * part, slice.X(column), slice.Y(row));
        }
    SliceMixture result;
    result.count = mixture.count;
    result.parts[0] = first.Moments(slice);
    if (mixture.count == 2) result.parts[1] = second.Moments(slice);
    return result;
}

SliceMixture FitSlice(const Slice& slice, int count, int steps) {
    SliceMixture mixture = ShareOut(slice, SliceMixture{});
    if (count == 1) return mixture;
    // Two Gaussians of one mean, so that the parts go by their width and part 0 stays the narrow one.
    const SliceGaussian all = mixture.parts[0];
    mixture.count = 2;
    mixture.parts[0] = {0.5, all.meanX, 0.4 * all.varianceX, 0.4 * all.varianceY};
    mixture.parts[1] = {0.5, all.meanX, 1.6 * all.varianceX, 1.6 * all.varianceY};
    for (int i = 0; i < steps; ++i) mixture = ShareOut(slice, mixture);
    return mixture;
}

}  // namespace lacquer::gaussfit
