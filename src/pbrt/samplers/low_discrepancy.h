// Building blocks of low-discrepancy sequences: radical inverses, Sobol matrices and their scrambling.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "pbrt/core/rng.h"

namespace lacquer {

/// How a sequence is randomised; every choice keeps its stratification.
enum class Randomization { None, PermuteDigits, FastOwen, Owen };

/// The upper 24 bits of a binary fraction as a float in [0,1); truncation keeps it in its elementary
/// interval.
constexpr float UnitFloat32(uint32_t fraction) { return float(int(fraction >> 8)) * 0x1p-24f; }

constexpr uint32_t ReverseBits(uint32_t v) {
    v = (v << 16) | (v >> 16);
    v = ((v & 0x00ff00ff) << 8) | ((v & 0xff00ff00) >> 8);
    v = ((v & 0x0f0f0f0f) << 4) | ((v & 0xf0f0f0f0) >> 4);
    v = ((v & 0x33333333) << 2) | ((v & 0xcccccccc) >> 2);
    return ((v & 0x55555555) << 1) | ((v & 0xaaaaaaaa) >> 1);
}

// In what follows "reversed" means that bit k of an integer is the binary digit of weight 2^-(k+1) of the
// fraction: sequences and scrambles start from the most significant digit, which then costs no reversal.

/// The least count above `samples` (0 or more) after which a sequence in base 2 whose first 2^k points are a
/// net is no worse than before: 2^k, and from 8 on 3 * 2^k, which is a net and one of half its size.
constexpr int NextCountOfNets(int samples) {
    int power = 1;
    while (power <= samples) power *= 2;
    const int half = power / 4 * 3;
    return power >= 16 && half > samples ? half : power;
}

/// Second dimension of the Sobol sequence, reversed: bit k is the parity of the bits j of `index` with
/// binomial(j, k) odd. That matrix is a Kronecker power, so its product takes one step for each bit of j. The
/// first dimension, reversed, is the index itself.
constexpr uint32_t SobolSecond(uint32_t index) {
    index ^= index >> 16;
    index ^= (index >> 8) & 0x00ff00ff;
    index ^= (index >> 4) & 0x0f0f0f0f;
    index ^= (index >> 2) & 0x33333333;
    return index ^ ((index >> 1) & 0x55555555);
}
/// The same with 64 bits.
constexpr uint64_t SobolSecond(uint64_t index) {
    index ^= index >> 32;
    index ^= (index >> 16) & 0x0000ffff0000ffffull;
    index ^= (index >> 8) & 0x00ff00ff00ff00ffull;
    index ^= (index >> 4) & 0x0f0f0f0f0f0f0f0full;
    index ^= (index >> 2) & 0x3333333333333333ull;
    return index ^ ((index >> 1) & 0x5555555555555555ull);
}

/// Hashed nested uniform scramble of a reversed fraction: each output bit is flipped as a function of the
/// bits below it [Laine and Karras 2011, sec. 3.1; Burley 2020], with the constants of [Vegdahl 2021].
constexpr uint32_t FastOwenReversed(uint32_t v, uint32_t seed) {
    v ^= v * 0x3d20adeau;
    v += seed;
    v *= (seed >> 16) | 1;
    v ^= v * 0x05526c56u;
    return v ^ (v * 0x53a22864u);
}

/// Nested uniform scramble [Owen 1995] of a reversed fraction with an independent hash at every node of the
/// tree; the 24 digits that a float in [0,1) has.
uint32_t OwenReversed(uint32_t v, uint32_t seed);

/// Randomises the N reversed fractions of `v` alike.
template <size_t N>
void RandomizeReversed(Randomization randomization, uint32_t seed, std::array<uint32_t, N>& v) {
    switch (randomization) {
        case Randomization::None:
            break;
        case Randomization::PermuteDigits:
            for (size_t l = 0; l < N; ++l) v[l] ^= seed;
            break;
        case Randomization::FastOwen:
            for (size_t l = 0; l < N; ++l) v[l] = FastOwenReversed(v[l], seed);
            break;
        case Randomization::Owen:
            for (size_t l = 0; l < N; ++l) v[l] = OwenReversed(v[l], seed);
            break;
    }
}

/// Generator matrices of the Sobol sequence [Joe and Kuo 2008], from the embedded data.
/// columns: [dimension][bit of the index], reversed fractions; 64 bits of index.
using SobolColumns = std::array<uint32_t, 64>;
std::vector<SobolColumns> MakeSobolMatrices(int dimensions);

/// The first `count` primes.
std::vector<int> FirstPrimes(int count);

/// Radical inverses in one base with all digits permuted, by tables of several digits at a time. Values are
/// exact to 2^-24, as floats from 1/2 to 1 are: what comes after the digits of that weight is left out.
class RadicalInverse {
  public:
    /// Indices stay below 2^kIndexBits.
    static constexpr int kIndexBits = 50;
    /// Digit permutations depend on (seed, base, digit position); without `permute` they are identities.
    RadicalInverse(int base, bool permute, uint64_t seed);
    /// In [0,1).
    float operator()(uint64_t index) const {
        double sum = 0;
        const uint16_t* digits = digits_.data();
        for (int chunk = 0; chunk < numChunks_; ++chunk, digits += chunkSize_) {
            const uint64_t quotient = Quotient(index);
            sum += double(digits[index - quotient * chunkSize_]) * scales_[size_t(chunk)];
            index = quotient;
        }
        return std::min(float(sum), OneMinusEpsilon);
    }

    static constexpr int kLanes = 8, kMaxChunks = 5;
    using Lanes = std::array<float, kLanes>;
    /// A distance between indices by the chunks of its digits, the lowest first.
    using Step = std::array<int, kMaxChunks>;
    Step StepOf(uint64_t distance) const;
    /// Those of first, first + step, first + 2 step ..., as operator() has them.
    void OfProgression(uint64_t first, const Step& step, Lanes& values) const;

  private:
    /// index / chunkSize: the high half of the product with ceil(2^64 / chunkSize), exact for index < 2^64 /
    /// chunkSize.
    uint64_t Quotient(uint64_t index) const {
        __extension__ using Wide = unsigned __int128;
        return uint64_t((Wide(index) * reciprocal_) >> 64);
    }

    uint64_t chunkSize_ = 0, reciprocal_ = 0;
    int numChunks_ = 0;
    std::vector<uint16_t> digits_;  ///< [chunk position][chunk]: its digits permuted and mirrored
    std::array<double, kMaxChunks> scales_ = {};  ///< by chunk position: its weight
};

/// Radical inverse with nested uniform scrambling: each digit is permuted as a function of those before it.
float OwenRadicalInverse(int base, uint64_t index, uint64_t seed);

}  // namespace lacquer
