#include "denoise/regression.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "pbrt/core/parallel.h"

namespace lacquer::denoise {
namespace {

constexpr int kNumTerms = kNumFeatures + 1;
using Terms = Eigen::Matrix<float, kNumTerms, 1>;
using Matrix = Eigen::Matrix<float, kNumTerms, kNumTerms>;
using Coefficients = Eigen::Matrix<float, kNumTerms, 3>;

/// Weights below it change nothing that can be seen.
constexpr float kMinWeight = 1e-3f;
/// Added to the squares of the features, a part for the weights' sum and one of its own: where a feature does
/// not vary, or few pixels are alike, its coefficient is nearly zero.
constexpr float kRidge = 1e-3f, kFewPixels = 0.1f;

std::vector<Bounds2i> TilesOf(Int2 size) {
    std::vector<Bounds2i> tiles;
    for (int y = 0; y < size.y; y += kTile)
        for (int x = 0; x < size.x; x += kTile)
            tiles.push_back({{x, y}, glm::min(Int2(x + kTile, y + kTile), size)});
    return tiles;
}

/// 1, and how the features of q differ from those of p.
Terms TermsOf(const Features& features, Int2 p, Int2 q) {
    const auto &a = features.At(p.x, p.y), &b = features.At(q.x, q.y);
    Terms terms;
    terms[0] = 1;
    for (int i = 0; i < kNumFeatures; ++i) terms[i + 1] = b[size_t(i)] - a[size_t(i)];
    return terms;
}

/// What the windows around the pixels of a tile say of all pixels that they contain.
struct Contribution {
    Bounds2i bounds;
    std::vector<std::array<float, 4>> sums;  ///< weighted colours, and weights
    std::array<float, 4>& At(Int2 p) {
        return sums[size_t(p.y - bounds.min.y) * size_t(bounds.Width()) + size_t(p.x - bounds.min.x)];
    }
};

class WindowRegression {
  public:
    WindowRegression(const Color& colors, const Features& features, const Features& variances,
                     const PatchWeights& weights)
        : colors_(colors), features_(features), variances_(variances), weights_(weights) {}

    void AddWindow(Int2 p, Contribution* contribution) {
        Collect(p, contribution->bounds);
        const Coefficients coefficients = Solve(p);
        for (size_t i = 0; i < pixels_.size(); ++i) {
            const Eigen::Matrix<float, 3, 1> value = coefficients.transpose() * terms_[i];
            std::array<float, 4>& sum = contribution->At(pixels_[i]);
            for (int c = 0; c < 3; ++c) sum[size_t(c)] += weightOf_[i] * value[c];
            sum[3] += weightOf_[i];
        }
    }

  private:
    /// The pixels of the window that count.
    void Collect(Int2 p, const Bounds2i& bounds) {
        pixels_.clear();
        weightOf_.clear();
        terms_.clear();
        const int radius = weights_.WindowRadius();
        for (int dy = -radius; dy <= radius; ++dy)
            for (int dx = -radius; dx <= radius; ++dx) {
                const Int2 q = p + Int2(dx, dy);
                const float weight = weights_.At(p, {dx, dy});
                if (weight < kMinWeight || !bounds.Contains(q)) continue;
                pixels_.push_back(q);
                weightOf_.push_back(weight);
                terms_.push_back(TermsOf(features_, p, q));
            }
    }
    Coefficients Solve(Int2 p) const {
        Matrix normal = Matrix::Zero();
        Coefficients right = Coefficients::Zero();
        float total = 0;
        for (size_t i = 0; i < pixels_.size(); ++i) {
            const Terms weighted = weightOf_[i] * terms_[i];
            normal.noalias() += weighted * terms_[i].transpose();
            const auto& color = colors_.At(pixels_[i].x, pixels_[i].y);
            right.noalias() += weighted * Eigen::Map<const Eigen::RowVector3f>(color.data());
            total += weightOf_[i];
        }
        for (int i = 1; i < kNumTerms; ++i)
            normal(i, i) += total * (kRidge + variances_.At(p.x, p.y)[size_t(i - 1)]) + kFewPixels;
        return normal.ldlt().solve(right);
    }

    const Color& colors_;
    const Features &features_, &variances_;
    const PatchWeights& weights_;
    std::vector<Int2> pixels_;
    std::vector<float> weightOf_;
    std::vector<Terms, Eigen::aligned_allocator<Terms>> terms_;
};

}  // namespace

template <size_t N, size_t M>
Planes<N> WeightedMeans(const Planes<N>& values, const Guide<M>& guide, const PatchOptions& options) {
    Planes<N> result(values.Size());
    const std::vector<Bounds2i> tiles = TilesOf(values.Size());
    ParallelFor(int64_t(tiles.size()), [&](int64_t t) {
        const Bounds2i& tile = tiles[size_t(t)];
        const PatchWeights weights(guide, tile, options);
        const int radius = options.windowRadius;
        for (int y = tile.min.y; y < tile.max.y; ++y)
            for (int x = tile.min.x; x < tile.max.x; ++x) {
                typename Planes<N>::Value sum{};
                float total = 0;
                for (int dy = -radius; dy <= radius; ++dy)
                    for (int dx = -radius; dx <= radius; ++dx) {
                        const float weight = weights.At({x, y}, {dx, dy});
                        if (weight == 0) continue;
                        const auto& value = values.Clamped(x + dx, y + dy);
                        for (size_t c = 0; c < N; ++c) sum[c] += weight * value[c];
                        total += weight;
                    }
                for (size_t c = 0; c < N; ++c) result.At(x, y)[c] = sum[c] / total;
            }
    });
    return result;
}

template Planes<1> WeightedMeans(const Planes<1>&, const Guide<3>&, const PatchOptions&);
template Planes<3> WeightedMeans(const Planes<3>&, const Guide<3>&, const PatchOptions&);
template Features WeightedMeans(const Features&, const Guide<kNumFeatures>&, const PatchOptions&);

Color Regress(const Color& colors, const Guide<3>& guide, const Features& features, const Features& variances,
              const PatchOptions& options, Observer* observer) {
    const Int2 size = colors.Size();
    const Bounds2i image{{0, 0}, size};
    const std::vector<Bounds2i> tiles = TilesOf(size);
    std::vector<Contribution> contributions(tiles.size());
    ParallelFor(int64_t(tiles.size()), [&](int64_t t) {
        const Bounds2i& tile = tiles[size_t(t)];
        const Int2 reach(options.windowRadius);
        Contribution& contribution = contributions[size_t(t)];
        contribution.bounds = Bounds2i{tile.min - reach, tile.max + reach}.Intersect(image);
        contribution.sums.resize(size_t(contribution.bounds.Area()));
        const PatchWeights weights(guide, tile, options);
        WindowRegression regression(colors, features, variances, weights);
        for (int y = tile.min.y; y < tile.max.y; ++y)
            for (int x = tile.min.x; x < tile.max.x; ++x) regression.AddWindow({x, y}, &contribution);
        if (observer) observer->Advance(tile.Area());
    });
    // In the order of the tiles, whoever made them: sums of floats depend on it.
    Planes<4> sums(size);
    for (Contribution& contribution : contributions)
        for (int y = contribution.bounds.min.y; y < contribution.bounds.max.y; ++y)
            for (int x = contribution.bounds.min.x; x < contribution.bounds.max.x; ++x)
                for (size_t c = 0; c < 4; ++c) sums.At(x, y)[c] += contribution.At({x, y})[c];
    Color result(size);
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x)
            for (size_t c = 0; c < 3; ++c) result.At(x, y)[c] = sums.At(x, y)[c] / sums.At(x, y)[3];
    return result;
}

}  // namespace lacquer::denoise
