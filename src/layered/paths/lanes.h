// Loops over many Gaussians at once. Each loop has a constant count and a body without branches, so that
// compilers turn it into vector instructions of whatever width the target has.
#pragma once

#include <array>
#include <cstdint>

#include "pbrt/core/math.h"

namespace lacquer::layered {

/// Scales of a mixture of Gaussians, and pairs of two such scales.
inline constexpr int kNumScales = 4, kNumPairs = kNumScales * kNumScales;

/// One number for each scale, and for each pair (j, k) of scales at index kNumScales j + k.
using PerScale = std::array<float, kNumScales>;
using PerPair = std::array<float, kNumPairs>;

/// e^x, clamped so that it never is 0.
inline float PositiveExp(float x) { return Exp(std::max(x, -87.f)); }

/// The numbers of the scales k at all pairs (j, k).
inline PerPair RepeatForPairs(const PerScale& x) {
    PerPair pairs;
    for (int j = 0; j < kNumScales; ++j)
        for (int k = 0; k < kNumScales; ++k) pairs[size_t(kNumScales * j + k)] = x[size_t(k)];
    return pairs;
}

template <size_t N>
float SumOf(const std::array<float, N>& x) {
    // Four sums at a time: their order is the same for all widths of vectors.
    std::array<float, 4> sums{};
    for (size_t i = 0; i < N; i += 4)
        for (size_t k = 0; k < 4; ++k) sums[k] += x[i + k];
    return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

}  // namespace lacquer::layered
