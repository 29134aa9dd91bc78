// Sums that do not depend on order or partition: by bits, over all of a double's range; and how exact they
// are.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "pbrt/core/rng.h"
#include "pbrt/film/exact_sums.h"
#include "support/statistics.h"

namespace lacquer::exact_sums_test {
namespace {

double SumOf(const std::vector<double>& values) {
    ExactSums sum(1);
    for (const double x : values) sum.Add(0, x);
    return sum[0];
}
uint64_t Bits(double x) { return std::bit_cast<uint64_t>(x); }

/// Numbers of both signs whose exponents are uniform within `octaves` on both sides of 0.
std::vector<double> Numbers(int count, double octaves, Rng& rng) {
    std::vector<double> numbers;
    for (int i = 0; i < count; ++i)
        numbers.push_back((rng.Uniform() < 0.5f ? -1 : 1) *
                          std::exp2(octaves * (2 * double(rng.Uniform()) - 1)) *
                          (1 + double(rng.Uniform()) + 0x1p-24 * double(rng.Uniform())));
    return numbers;
}
void Shuffle(std::vector<double>* values, Rng& rng) {
    for (size_t i = values->size(); i > 1; --i)
        std::swap((*values)[i - 1], (*values)[rng.UniformInt(uint32_t(i))]);
}

class ExactSumsOver : public testing::TestWithParam<double> {};

/// In 50 orders, each of which a plain sum would change with high probability; and so it does, as a control.
TEST_P(ExactSumsOver, EveryOrderGivesTheSameBits) {
    Rng rng(test::SeedOf(test::FullTestName()));
    std::vector<double> values = Numbers(300, GetParam(), rng);
    const double expected = SumOf(values);
    const double plain = std::accumulate(values.begin(), values.end(), 0.0);
    int numPlainChanges = 0;
    for (int order = 0; order < 50; ++order) {
        Shuffle(&values, rng);
        if (order == 0) std::sort(values.begin(), values.end());
        if (order == 1) std::sort(values.begin(), values.end(), std::greater<>());
        if (order == 2)
            std::sort(values.begin(), values.end(),
                      [](double a, double b) { return std::abs(a) < std::abs(b); });
        if (order == 3)
            std::sort(values.begin(), values.end(),
                      [](double a, double b) { return std::abs(a) > std::abs(b); });
        ASSERT_EQ(Bits(SumOf(values)), Bits(expected)) << order;
        numPlainChanges += Bits(std::accumulate(values.begin(), values.end(), 0.0)) != Bits(plain);
    }
    if (GetParam() > 0 && GetParam() < 100) {  // plain sums of numbers of one exponent happen to be exact
        EXPECT_GT(numPlainChanges, 10);
    }
}

/// Divided among up to 20 sums, some empty, which are added in any order and nesting.
TEST_P(ExactSumsOver, EveryPartitionGivesTheSameBits) {
    Rng rng(test::SeedOf(test::FullTestName()));
    for (int trial = 0; trial < 50; ++trial) {
        const std::vector<double> values = Numbers(200, GetParam(), rng);
        std::vector<ExactSums> parts(1 + rng.UniformInt(20), ExactSums(1));
        for (const double x : values) parts[rng.UniformInt(uint32_t(parts.size()))].Add(0, x);
        while (parts.size() > 1) {
            const size_t from = rng.UniformInt(uint32_t(parts.size() - 1));
            std::swap(parts[from], parts.back());
            const ExactSums last = parts.back();
            parts.pop_back();
            parts[rng.UniformInt(uint32_t(parts.size()))].Add(last);
        }
        ASSERT_EQ(Bits(parts[0][0]), Bits(SumOf(values))) << trial;
    }
}

/// To 2^-36 of the largest number for each number, against sums of long doubles.
TEST_P(ExactSumsOver, AreAsExactAsTheySay) {
    Rng rng(test::SeedOf(test::FullTestName()));
    for (int trial = 0; trial < 200; ++trial) {
        const std::vector<double> values = Numbers(100, GetParam(), rng);
        long double sum = 0;
        double largest = 0;
        for (const double x : values) {
            sum += static_cast<long double>(x);
            largest = std::max(largest, std::abs(x));
        }
        const double bound = 100 * std::ldexp(largest, -36);
        ASSERT_LE(std::abs(double(static_cast<long double>(SumOf(values)) - sum)), bound);
    }
}

INSTANTIATE_TEST_SUITE_P(Octaves, ExactSumsOver, testing::Values(0.0, 3.0, 20.0, 80.0, 500.0, 970.0));

/// A number alone is rounded to 35 binary digits or more, at every exponent, whichever bin it begins in.
TEST(ExactSums, ASingleNumberIsKept) {
    for (int exponent = -970; exponent <= 1023; ++exponent)
        for (const double mantissa : {1.0, 1.5, 1.9999999999, -1.2345678901234}) {
            const double x = std::ldexp(mantissa, exponent);
            ASSERT_NEAR(SumOf({x}) / x, 1, 0x1p-36) << exponent;
        }
    EXPECT_EQ(SumOf({double(0.1f), double(1e-3f), 7.25}), double(0.1f) + double(1e-3f) + 7.25);
    EXPECT_EQ(SumOf({}), 0);
}

/// What one number adds is taken away by its negative, whatever came between.
TEST(ExactSums, OppositesCancel) {
    Rng rng(test::SeedOf(test::FullTestName()));
    std::vector<double> values = Numbers(500, 100, rng);
    for (size_t i = 0; i < 500; ++i) values.push_back(-values[i]);
    Shuffle(&values, rng);
    EXPECT_EQ(SumOf(values), 0);
}

TEST(ExactSums, WhatIsNotFiniteCountsAsZero) {
    constexpr double kInf = std::numeric_limits<double>::infinity();
    EXPECT_EQ(SumOf({1, kInf, -kInf, std::numeric_limits<double>::quiet_NaN(), 2}), 3);
    EXPECT_EQ(SumOf({5e-324, -5e-324, 0., -0.}), 0);
    EXPECT_GT(SumOf({std::numeric_limits<double>::max()}), 1.7e308);
}

/// A million equal numbers whose plain sum of floats would stand still: no bias, and room for many.
TEST(ExactSums, ManyNumbersDoNotOverflow) {
    ExactSums sum(1);
    const double x = std::ldexp(0.99999999, 34);  // next to the limit of its level
    for (int i = 0; i < 1000000; ++i) sum.Add(0, x);
    EXPECT_NEAR(sum[0] / (1e6 * x), 1, 1e-15);
    for (int doubling = 0; doubling < 8; ++doubling) sum.Add(ExactSums(sum));  // 256e6, about 2^28
    EXPECT_NEAR(sum[0] / (256e6 * x), 1, 1e-15);
}

TEST(ExactSums, NeighboursDoNotMix) {
    ExactSums sums(3);
    sums.Add(0, 1e-300);
    sums.Add(1, 1e300);
    sums.Add(2, 1);
    EXPECT_NEAR(sums[0] / 1e-300, 1, 1e-10);
    EXPECT_NEAR(sums[1] / 1e300, 1, 1e-10);
    EXPECT_EQ(sums[2], 1);
    EXPECT_EQ(sums.Bytes(), 51u);
}

}  // namespace
}  // namespace lacquer::exact_sums_test
