// Two ways of rendering a scene against each other, part by part of the image.
#pragma once

#include <array>
#include <cmath>
#include <functional>

#include "integrators/render_fixtures.h"

namespace lacquer::test {

/// Colours of the blocks of an image, and of the whole.
constexpr int kBlocks = 4;
constexpr size_t kNumMeans = 3 * (kBlocks * kBlocks + 1);
inline std::array<double, kNumMeans> BlocksOf(const Image& image) {
    const Int2 size = image.Resolution();
    std::array<double, kNumMeans> blocks{};
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x)
            for (int c = 0; c < 3; ++c) {
                const double value = double(image.Get({x, y}, c)) / (size.x * size.y);
                blocks[size_t(3 * (y * kBlocks / size.y * kBlocks + x * kBlocks / size.x) + c)] +=
                    value * kBlocks * kBlocks;
                blocks[kNumMeans - 3 + size_t(c)] += value;
            }
    return blocks;
}

struct Rendering {
    std::string name;
    std::function<std::string(uint64_t seed)> text;  ///< of the scene, with independent samples
    RenderOptions options = {};
};
inline std::array<RunningMean, kNumMeans> MeansOf(const Rendering& rendering, int count, uint64_t seed) {
    std::array<RunningMean, kNumMeans> means;
    for (int k = 0; k < count; ++k) {
        const RenderSetup setup = BuildText(rendering.text(Hash(seed, k)));
        RenderAll(setup, rendering.options);
        const auto blocks = BlocksOf(*setup.film->Develop());
        for (size_t i = 0; i < kNumMeans; ++i) means[i].Add(blocks[i]);
    }
    return means;
}

/// Sixteen renders by each. @param scale  of what b finds, by a control
inline Outcome CompareRenders(const Rendering& a, const Rendering& b, double scale, uint64_t seed) {
    constexpr int kCount = 16;
    const auto meansA = MeansOf(a, kCount, Hash(seed, 1));
    const auto meansB = MeansOf(b, kCount, Hash(seed, 2));
    std::vector<Outcome> outcomes;
    for (size_t i = 0; i < kNumMeans; ++i) {
        const double variance = (meansA[i].Variance() + meansB[i].Variance()) / kCount;
        const double t = (scale * meansB[i].Mean() - meansA[i].Mean()) / std::sqrt(std::max(variance, 1e-16));
        // Student's t as a normal deviate (Wallace's approximation). Where one of the methods has nearly all
        // of the variance, it has the degrees of freedom of that one.
        constexpr double kDegrees = kCount - 1;
        const double z =
            std::sqrt(kDegrees * std::log1p(t * t / kDegrees)) * (8 * kDegrees + 1) / (8 * kDegrees + 3);
        outcomes.push_back({NormalTwoSided(z),
                            b.name + ", part " + std::to_string(i) + ": " + std::to_string(meansB[i].Mean()) +
                                " of " + std::to_string(meansA[i].Mean()) + ", t " + std::to_string(t)});
    }
    return WorstOf(outcomes);
}

}  // namespace lacquer::test
