// How much less variance points have than independent ones, by the order of interactions: of nets that are
// linear over GF(2).
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace lacquer::test {

/// By rows, from the digit of the greatest weight: which bits of an index make it.
using BitMatrix = std::array<uint32_t, 12>;

/// The matrix of the Sobol sequence's second dimension, after another: of its points in another order.
BitMatrix SobolSecondAfter(const BitMatrix& order);

/// Of the first 2^m points with a nested uniform scramble, relative to as many independent ones: the mean of
/// the gain coefficients [Owen 1997] of an interaction of all these dimensions, over levels from 1 to
/// `levels` of each, a level weighing 2.8 times as much as the next one (2 for functions with edges, 4 for
/// smooth ones). 0: such interactions make no noise. 1: as independent points. Cost: (levels + 1)^dimensions
/// ranks.
double MeanGain(std::span<const BitMatrix* const> dimensions, int m, int levels);

/// The mean of interactions of one dimension of a pair with one of another.
struct PairOfDimensions {
    explicit PairOfDimensions(const BitMatrix& order) : x(order), y(SobolSecondAfter(order)) {}
    BitMatrix x, y;
};
double MeanGainAcross(const PairOfDimensions& a, const PairOfDimensions& b, int m);

}  // namespace lacquer::test
