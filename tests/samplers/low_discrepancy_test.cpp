#include "pbrt/samplers/low_discrepancy.h"

#include <gtest/gtest.h>

#include <set>

#include "support/statistics.h"

namespace lacquer::low_discrepancy_test {
namespace {

TEST(RadicalInverse, MirrorsTheDigits) {
    EXPECT_EQ(RadicalInverse(2, false, 0)(6), 0.375f);            // 110 -> 0.011
    EXPECT_NEAR(RadicalInverse(3, false, 0)(5), 7.f / 9, 1e-7f);  // 12 -> 0.21
    EXPECT_NEAR(RadicalInverse(37, false, 0)(37 * 37 * 5 + 2), 2 / 37.f + 5 / 50653.f, 1e-7f);
    EXPECT_EQ(RadicalInverse(719, false, 0)(0), 0);
    // The largest index, against the digits one by one.
    const uint64_t index = (uint64_t(1) << RadicalInverse::kIndexBits) - 1;
    for (const int base : FirstPrimes(128)) {
        double value = 0, scale = 1;
        for (uint64_t rest = index; rest != 0; rest /= uint64_t(base)) {
            scale /= base;
            value += double(rest % uint64_t(base)) * scale;
        }
        EXPECT_NEAR(RadicalInverse(base, false, 0)(index), value, 1e-7) << base;
    }
}

/// Eight indices at a time, with carries from chunk to chunk.
TEST(RadicalInverse, ProgressionsHaveTheirValues) {
    Rng rng(test::SeedOf(test::FullTestName()));
    for (const int base : FirstPrimes(128)) {
        const RadicalInverse inverse(base, true, 5);
        std::vector<std::pair<uint64_t, uint64_t>> progressions = {{0, 0}, {0, 1}, {uint64_t(base) - 1, 1}};
        for (uint64_t power = uint64_t(base); power < uint64_t(1) << 46; power *= uint64_t(base)) {
            progressions.emplace_back(power - 1, 1);
            progressions.emplace_back(power - 1, power - 1);
            progressions.emplace_back(rng.NextBits() >> 15, rng.NextBits() % power);
        }
        for (const auto& [first, step] : progressions) {
            RadicalInverse::Lanes values;
            inverse.OfProgression(first, inverse.StepOf(step), values);
            for (uint64_t l = 0; l < values.size(); ++l)
                EXPECT_NEAR(values[l], inverse(first + l * step), 6e-8f)
                    << base << ' ' << first << ' ' << step;
        }
    }
}

TEST(RadicalInverse, EveryRandomizationKeepsTheStrata) {
    // Any b^k consecutive indices fall into b^k different intervals; values are rounded, so the test shifts
    // by their error.
    for (const int base : {2, 3, 5, 7, 11, 37})
        for (const int start : {0, 7 * base * base}) {
            const int count = base * base;
            const RadicalInverse permuted(base, true, 77);
            std::set<int> plain, owen;
            for (int i = 0; i < count; ++i) {
                const auto index = uint64_t(start + i);
                plain.insert(int(double(permuted(index)) * count + 1e-4));
                owen.insert(int(double(OwenRadicalInverse(base, index, 99)) * count + 1e-4));
            }
            EXPECT_EQ(int(plain.size()), count) << base;
            EXPECT_EQ(int(owen.size()), count) << base;
        }
}

TEST(Sobol, TheSecondDimensionIsItsMatrix) {
    const std::vector<SobolColumns> matrices = MakeSobolMatrices(2);
    Rng rng(test::SeedOf(test::FullTestName()));
    for (int i = 0; i < 1000; ++i) {
        const uint64_t index = rng.NextBits();
        uint32_t value = 0;
        for (size_t k = 0; k < 64; ++k)
            if ((index >> k) & 1) value ^= matrices[1][k];
        EXPECT_EQ(uint32_t(SobolSecond(index)), value);
        EXPECT_EQ(SobolSecond(uint32_t(index)), uint32_t(SobolSecond(index & 0xffffffff)));
    }
}

TEST(Sobol, HasItsKnownPoints) {
    // Dimension 3 (s = 2, a = 1, m = 1, 3): m_3 = 4*3 ^ ... = 4 m_1 ^ 2 a m_2 ^ m_1 = 4 ^ 6 ^ 1 = 3.
    const std::vector<SobolColumns> matrices = MakeSobolMatrices(3);
    EXPECT_EQ(ReverseBits(matrices[2][0]), 1u << 31);
    EXPECT_EQ(ReverseBits(matrices[2][1]), 3u << 30);
    EXPECT_EQ(ReverseBits(matrices[2][2]), 3u << 29);
}

TEST(Sobol, EveryDimensionIsStratified) {
    // Column k ends at digit k: the first 2^m points are in 2^m different intervals for every m.
    for (const SobolColumns& columns : MakeSobolMatrices(1024))
        for (size_t k = 0; k < 32; ++k) EXPECT_EQ(columns[k] >> k, 1u);
}

TEST(OwenScramble, BothKindsAreNestedPermutations) {
    // Two inputs that first differ in bit t (in the reversed sense) have outputs that first differ in bit t.
    Rng rng(test::SeedOf(test::FullTestName()));
    for (int i = 0; i < 20000; ++i) {
        const auto v = uint32_t(rng.NextBits()), seed = uint32_t(rng.NextBits());
        const int t = int(rng.UniformInt(24));
        const uint32_t w = v ^ (uint32_t(rng.NextBits()) << t | 1u << t);
        ASSERT_EQ((v ^ w) & ((1u << t) - 1), 0u);
        const bool differs = ((v ^ w) >> t) & 1;
        for (const auto scramble : {FastOwenReversed, OwenReversed}) {
            const uint32_t difference = scramble(v, seed) ^ scramble(w, seed);
            EXPECT_EQ(difference & ((1u << t) - 1), 0u);
            EXPECT_EQ(bool((difference >> t) & 1), differs);
        }
    }
}

/// Of many seeds, how often the digit of weight 2^-(bit+1) of a fixed fraction is flipped.
test::Outcome FlipRate(uint32_t (*scramble)(uint32_t, uint32_t), uint32_t v, int bit, uint64_t seed) {
    test::RunningMean flips;
    Rng rng(seed);
    for (int i = 0; i < 20000; ++i) flips.Add(((scramble(v, uint32_t(rng.NextBits() >> 32)) ^ v) >> bit) & 1);
    return test::ZTest(flips, 0.5, 0, "flips of a digit");
}

TEST(OwenScramble, FlipsEveryDigitHalfTheTime) {
    const double alpha = test::SidakAlpha(1e-3, 48);
    for (const auto scramble : {FastOwenReversed, OwenReversed})
        for (int bit = 0; bit < 24; ++bit)
            EXPECT_TRUE(test::Passes(test::FullTestName() + std::to_string(bit), alpha, [&](uint64_t seed) {
                return FlipRate(scramble, 0x5a3c99u, bit, seed);
            }));
    // Negative control, with power: a flip rate of 0.53 is 8 standard errors off; this one never flips half
    // of the digits.
    const auto broken = [](uint32_t v, uint32_t seed) { return v ^ (seed & 0x555555u); };
    EXPECT_LT(FlipRate(broken, 0x5a3c99u, 1, 1).pValue, 1e-12);
}

TEST(NextCountOfNets, ArePowersOfTwoAndThreeQuartersOfThem) {
    std::vector<int> counts;
    for (int n = 0; n < 64; n = counts.back()) counts.push_back(NextCountOfNets(n));
    EXPECT_EQ(counts, (std::vector<int>{1, 2, 4, 8, 12, 16, 24, 32, 48, 64}));
    EXPECT_EQ(NextCountOfNets(9), 12);
}

}  // namespace
}  // namespace lacquer::low_discrepancy_test
