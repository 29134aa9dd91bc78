#include "pbrt/core/rng.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "support/statistics.h"

namespace lacquer::rng_test {
namespace {

using test::ChiSquareTest;
using test::FullTestName;
using test::Outcome;
using test::Passes;
using test::RunningMean;
using test::SeedOf;
using test::ZTest;

constexpr double kAlpha = 1e-4;  // of each of about ten checks: a false alarm in a thousand

/// Chi-square of `count` values of [0,1) in 256 equal cells.
template <class Next>
Outcome Uniformity(int count, const Next& next) {
    std::vector<double> observed(256, 0), expected(256, count / 256.0);
    for (int i = 0; i < count; ++i) ++observed[size_t(next(i) * 256)];
    return ChiSquareTest(observed, expected);
}

TEST(MixBits, CanBeUndone) {
    // Each step of the mixer inverted: odd factors by their inverses modulo 2^64 (Newton), shifts by
    // repetition.
    const auto inverseOf = [](uint64_t a) {
        uint64_t x = a;
        for (int i = 0; i < 6; ++i) x *= 2 - a * x;
        return x;
    };
    const auto unshift = [](uint64_t v, int s) {
        uint64_t r = v;
        for (int i = s; i < 64; i += s) r = v ^ (r >> s);
        return r;
    };
    Rng rng(1);
    for (int i = 0; i < 1000; ++i) {
        const uint64_t v = i < 100 ? uint64_t(i) : rng.NextBits();
        uint64_t m = unshift(MixBits(v), 31);
        m = unshift(m * inverseOf(0x94d049bb133111ebull), 27);
        EXPECT_EQ(unshift(m * inverseOf(0xbf58476d1ce4e5b9ull), 30), v);
    }
}

// Power: 40,000 values in 256 cells see a relative deviation of 10 % in a quarter of the cells (noncentrality
// 400 * 0.25 = 100 over 256 +- 23) in nearly every run at 1e-4.
TEST(Hash, IsUniformOnPoorInputs) {
    constexpr int kCount = 40000;
    EXPECT_TRUE(Passes(FullTestName() + "/integers", kAlpha, [](uint64_t seed) {
        return Uniformity(kCount, [&](int i) { return UnitFloat(Hash(seed, i)); });
    }));
    EXPECT_TRUE(Passes(FullTestName() + "/pixels", kAlpha, [](uint64_t seed) {
        return Uniformity(kCount, [&](int i) { return UnitFloat(Hash(int(seed), i % 200, i / 200, 0)); });
    }));
    EXPECT_TRUE(Passes(FullTestName() + "/floats", kAlpha, [](uint64_t seed) {
        return Uniformity(kCount, [&](int i) {
            return UnitFloat(Hash(Vec3(float(i % 200), float(i / 200), 1), Vec3(float(seed % 97), 0, 1)));
        });
    }));
    EXPECT_TRUE(Passes(FullTestName() + "/low bits", kAlpha, [](uint64_t seed) {
        return Uniformity(kCount, [&](int i) { return float(Hash(seed, i) & 0xffff) / 65536; });
    }));
}

TEST(Hash, NegativeControlAHashThatFavoursSomeCellsIsFound) {
    const Outcome outcome = Uniformity(40000, [](int i) {
        const float u = UnitFloat(Hash(i));
        return u < 0.25f && i % 10 == 0 ? u + 0.5f : u;  // a quarter of the cells loses 10 %
    });
    EXPECT_LT(outcome.pValue, kAlpha);
}

TEST(Hash, DependsOnEveryArgumentAndTheirOrder) {
    std::set<uint64_t> seen;
    for (int a = 0; a < 20; ++a)
        for (int b = 0; b < 20; ++b)
            for (int c = 0; c < 20; ++c) seen.insert(Hash(a, b, c));
    EXPECT_EQ(seen.size(), 8000u);
    EXPECT_NE(Hash(1, 2), Hash(2, 1));
    EXPECT_NE(Hash(1), Hash(1, 0));
    EXPECT_NE(Hash(1.f), Hash(1));
}

TEST(UnitFloat, StaysBelowOne) {
    EXPECT_EQ(UnitFloat(0), 0);
    EXPECT_EQ(UnitFloat(~uint64_t(0)), OneMinusEpsilon);
}

/// z-tests of the first moments of numbers that should be uniform and independent of their predecessors.
template <class Next>
Outcome Moments(const Next& next) {
    RunningMean mean, square, product, cube;
    float last = next();
    for (int i = 0; i < 200000; ++i) {
        const float u = next();
        mean.Add(double(u));
        square.Add(double(u) * double(u));
        cube.Add(double(u) * double(u) * double(u));
        product.Add((double(u) - 0.5) * (double(last) - 0.5));
        last = u;
    }
    // The grid of 24 bits lies half a step low.
    const Outcome outcomes[] = {ZTest(mean, 1.0 / 2, 3e-8, "mean"), ZTest(square, 1.0 / 3, 6e-8, "square"),
                                ZTest(cube, 1.0 / 4, 9e-8, "cube"),
                                ZTest(product, 0, 0, "product with the last")};
    return test::WorstOf(outcomes);
}

// Power: the mean of 200,000 numbers has a standard error of 6.5e-4; a mean off by 0.005 is 7.7 of them.
TEST(Rng, HasTheMomentsOfTheUniformDistribution) {
    EXPECT_TRUE(Passes(FullTestName(), kAlpha, [](uint64_t seed) {
        Rng rng(seed);
        return Moments([&] { return rng.Uniform(); });
    }));
    EXPECT_TRUE(Passes(FullTestName() + "/pairs", kAlpha, [](uint64_t seed) {
        Rng rng(seed);
        Point2 pair(0);
        int i = 0;
        return Moments([&] {
            if (i++ % 2 == 0) pair = rng.Uniform2D();
            return i % 2 ? pair.x : pair.y;
        });
    }));
    // First numbers of streams with hashed seeds, as the render loop makes them.
    EXPECT_TRUE(Passes(FullTestName() + "/streams", kAlpha, [](uint64_t seed) {
        int i = 0;
        return Moments([&] { return Rng(Hash(seed, ++i, 3, 4)).Uniform(); });
    }));
}

TEST(Rng, NegativeControlASmallShiftOfTheMeanIsFound) {
    Rng rng(test::SeedOf(FullTestName()));
    EXPECT_LT(Moments([&] { return std::pow(rng.Uniform(), 0.98f); }).pValue, kAlpha);
}

TEST(Rng, NegativeControlCorrelatedNeighboursAreFound) {
    Rng rng(test::SeedOf(FullTestName()));
    float last = 0.5f;
    const auto next = [&] {
        if (rng.Uniform() > 0.05f) last = rng.Uniform();  // one in twenty repeats
        return last;
    };
    EXPECT_LT(Moments(next).pValue, kAlpha);
}

TEST(Rng, IntegersAreUniform) {
    for (const uint32_t n : {1u, 2u, 7u, 100u})
        EXPECT_TRUE(Passes(FullTestName() + "/" + std::to_string(n), kAlpha, [n](uint64_t seed) {
            Rng rng(seed);
            std::vector<double> observed(n, 0), expected(n, 50000.0 / n);
            for (int i = 0; i < 50000; ++i) ++observed[rng.UniformInt(n)];
            return ChiSquareTest(observed, expected);
        }));
}

TEST(Rng, EqualSeedsGiveEqualStreams) {
    Rng a(42), b(42), c(43);
    EXPECT_EQ(a.NextBits(), b.NextBits());
    EXPECT_NE(a.NextBits(), c.NextBits());
}

TEST(PermutationElement, IsABijection) {
    std::vector<uint32_t> lengths = {1000, 1023, 1024, 1025, 65537};
    for (uint32_t n = 1; n < 70; ++n) lengths.push_back(n);
    for (const uint32_t length : lengths)
        for (const uint32_t seed : {0u, 1u, 0xdeadbeefu, 0xffffffffu}) {
            std::vector<bool> seen(length, false);
            for (uint32_t i = 0; i < length; ++i) {
                const uint32_t p = PermutationElement(i, length, seed);
                ASSERT_LT(p, length);
                ASSERT_FALSE(seen[p]) << length << " " << seed;
                seen[p] = true;
            }
        }
}

TEST(Rng, CountsItsNumbers) {
    Rng rng(SeedOf(FullTestName()));
    const Rng start = rng;
    for (uint64_t count = 0; count < 1000; ++count) {
        ASSERT_EQ(rng.CountSince(start), count);
        if (count % 3 == 0)
            rng.Uniform2D();
        else if (count % 3 == 1)
            rng.Uniform();
        else
            rng.NextBits();
    }
}

// Power: 24 cells of 500 expected; a cell that is 20 % off is 4.5 sigma.
TEST(PermutationElement, TakesEachElementEverywhere) {
    EXPECT_TRUE(Passes(FullTestName(), kAlpha, [](uint64_t seed) {
        std::vector<double> observed(24, 0), expected(24, 500);
        for (int i = 0; i < 12000; ++i) ++observed[PermutationElement(5, 24, uint32_t(Hash(seed, i)))];
        return ChiSquareTest(observed, expected);
    }));
}

}  // namespace
}  // namespace lacquer::rng_test
