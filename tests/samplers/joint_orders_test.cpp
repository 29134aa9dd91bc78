#include "pbrt/samplers/joint_orders.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "pbrt/base/sampler.h"
#include "pbrt/core/rng.h"
#include "samplers/net_gains.h"
#include "support/statistics.h"

namespace lacquer::joint_orders_test {
namespace {

using namespace test;

BitMatrix MatrixOf(const JointOrders::Order& order) {
    BitMatrix matrix{};
    for (uint32_t column = 0; column < matrix.size(); ++column)
        for (uint32_t row = 0; row < matrix.size(); ++row)
            matrix[row] |= (order(uint32_t(1) << column) >> row & 1) << column;
    return matrix;
}

BitMatrix RandomOrder(Rng* rng) {
    BitMatrix matrix{};
    for (uint32_t row = 0; row < matrix.size(); ++row) {
        matrix[row] = uint32_t(1) << row;
        for (uint32_t column = row + 1; column < matrix.size(); ++column)
            matrix[row] |= uint32_t(rng->Uniform() < 0.5f) << column;
    }
    return matrix;
}

/// Over all pairs of some of them, and both of their dimensions.
double MeanGainOfPairs(const std::vector<PairOfDimensions>& pairs, int m) {
    double sum = 0;
    int count = 0;
    for (size_t i = 0; i < pairs.size(); ++i)
        for (size_t j = 0; j < i; ++j, ++count) sum += MeanGainAcross(pairs[i], pairs[j], m);
    return sum / count;
}

TEST(JointOrders, KeepEveryAlignedBlock) {
    const JointOrders& orders = JointOrders::Get();
    for (int i = 0; i < JointOrders::kCount; ++i)
        for (int m = 0; m <= JointOrders::kBits; ++m)
            for (const uint32_t first : {0u, 5u << m, 77777u << m}) {
                const uint32_t block = orders.Of(i)(first) >> m;
                std::vector<bool> isThere(size_t(1) << m);
                for (uint32_t k = 0; k < 1u << m; ++k) {
                    const uint32_t index = orders.Of(i)(first + k);
                    ASSERT_EQ(index >> m, block) << i << ' ' << m;
                    isThere[index & ((1u << m) - 1)] = true;
                }
                EXPECT_EQ(std::count(isThere.begin(), isThere.end(), true), 1 << m);
                EXPECT_EQ(block >> (12 - m), first >> 12);
            }
}

TEST(JointOrders, AreLinear) {
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < JointOrders::kCount; ++i)
        for (int k = 0; k < 1000; ++k) {
            const auto& order = JointOrders::Get().Of(i);
            const auto a = uint32_t(rng.Uniform() * 0x1p32f), b = uint32_t(rng.Uniform() * 0x1p32f);
            ASSERT_EQ(order(a ^ b), order(a) ^ order(b));
        }
}

// A net in two dimensions has no noise in interactions up to its number of points.
TEST(JointOrders, GainsAreThoseOfNets) {
    const PairOfDimensions sobol(MatrixOf(JointOrders::Get().Of(0)));
    EXPECT_EQ(sobol.x[3], 8u);
    for (int m : {4, 6, 10}) EXPECT_NEAR(MeanGain(std::array{&sobol.x, &sobol.y}, m, 2), 0, 1e-12) << m;
    // Twice the same dimension: 2^m times as much as independent ones at most, all of it at equal levels.
    EXPECT_GT(MeanGain(std::array{&sobol.x, &sobol.x}, 6, 5), 4);
    // Levels that no point tells apart any more: as independent ones.
    EXPECT_NEAR(MeanGain(std::array{&sobol.x, &sobol.y}, 0, 3), 1, 1e-12);
}

TEST(JointOrders, PairsHaveLessNoiseTogetherThanByChance) {
    std::vector<PairOfDimensions> ours;
    for (const int i : {0, 1, 3, 4, 6, 7}) ours.emplace_back(MatrixOf(JointOrders::Get().Of(i)));
    EXPECT_LT(MeanGainOfPairs(ours, 4), 1.3);
    EXPECT_LT(MeanGainOfPairs(ours, 6), 0.5);
    EXPECT_LT(MeanGainOfPairs(ours, 8), 0.25);
    EXPECT_LT(MeanGainOfPairs(ours, 10), 0.1);
    // Random ones have 1 in the mean, by few draws that are far worse than the others.
    Rng rng(SeedOf(FullTestName()));
    double sum = 0;
    constexpr int kDraws = 100;
    for (int i = 0; i < kDraws; ++i) {
        std::vector<PairOfDimensions> random;
        for (int k = 0; k < 6; ++k) random.emplace_back(RandomOrder(&rng));
        sum += MeanGainOfPairs(random, 8);
    }
    EXPECT_GT(sum / kDraws, 0.7);
}

/// Mean square error of the integral of a function of two pairs of dimensions over pixels: 0 and 1, and each
/// of those that paths use after it.
template <class Function>
double ErrorOf(const char* name, int samples, double exact, const Function& f) {
    constexpr int kSide = 32, kSeeds = 3;
    double sum = 0;
    for (const int second : {2, 6, 7, 9, 10})
        for (int seed = 0; seed < kSeeds; ++seed) {
            const Params none;
            const auto sampler = Registry<SamplerKind>::Find(name)({none, {kSide, kSide}, samples, seed});
            for (int pixel = 0; pixel < kSide * kSide; ++pixel) {
                double mean = 0;
                for (int i = 0; i < samples; ++i) {
                    sampler->StartPixelSample({pixel % kSide, pixel / kSide}, i);
                    const Point2 a = sampler->GetPixel2D();
                    for (int d = 2; d < second; ++d) sampler->Skip1D();
                    mean += f(a, sampler->Get2D()) / samples;
                }
                sum += Sqr(mean - exact) / (5 * kSeeds * Sqr(kSide));
            }
        }
    return sum;
}

// What varies smoothly with both, and a shadow's edge across pixel and light. With 15360 pixels the quotients
// are known to a few per cent; `paddedsobol`, whose pairs know nothing of each other, is the control. An edge
// has interactions of all levels, of which a net makes those of low ones less and some of high ones more: it
// wins or loses some.
TEST(JointOrders, LessNoiseInWhatDependsOnTwoPairs) {
    const auto edge = [](Point2 a, Point2 b) { return a.x + b.x < 1 ? 1. : 0.; };
    const auto smooth = [](Point2 a, Point2 b) { return double(a.x * b.y * a.y); };
    struct Case {
        int samples;
        double mostEdge, mostSmooth;
    };
    for (const Case& c : {Case{16, 1.25, 0.7}, Case{64, 0.75, 0.15}, Case{256, 1.6, 0.15}}) {
        const auto quotient = [&](double exact, const auto& f) {
            return ErrorOf("zsobol", c.samples, exact, f) / ErrorOf("paddedsobol", c.samples, exact, f);
        };
        EXPECT_LT(quotient(0.5, edge), c.mostEdge) << c.samples;
        EXPECT_LT(quotient(0.125, smooth), c.mostSmooth) << c.samples;
    }
    EXPECT_GT(ErrorOf("pmj02bn", 64, 0.5, edge), 0.9 * ErrorOf("paddedsobol", 64, 0.5, edge));
}

// Of three dimensions of a pixel, by all their digits down to the sixth: what no 4096 points tell apart. The
// orders have 4096 indices; were they the same again after that, more samples would bring nothing.
TEST(JointOrders, MoreSamplesThanTheOrdersHaveIndices) {
    constexpr int kLog2Samples = 15, kSeeds = 24;
    const auto digits = [](float x) { return int(x * 64) & 1; };
    double sum = 0;
    for (int seed = 0; seed < kSeeds; ++seed) {
        const Params none;
        const auto sampler = Registry<SamplerKind>::Find("zsobol")({none, {1, 1}, 1 << kLog2Samples, seed});
        double mean = 0;
        for (int i = 0; i < 1 << kLog2Samples; ++i) {
            sampler->StartPixelSample({0, 0}, i);
            const float a = sampler->GetPixel2D().x;
            for (int d = 2; d < 7; ++d) sampler->Skip1D();
            const float b = sampler->Get2D().x;
            sampler->Skip1D();
            const float c = sampler->Get2D().x;
            mean += std::ldexp(digits(a) ^ digits(b) ^ digits(c) ? 1. : -1., -kLog2Samples);
        }
        sum += Sqr(mean) / kSeeds;
    }
    // As of independent points, 2^-15, by a chi-square distribution of 24 degrees of freedom: below 1.8 times
    // that with a probability of 0.99. Repeated points have 2^-12 in the mean.
    EXPECT_LT(sum, std::ldexp(1.8, -kLog2Samples));
}

}  // namespace
}  // namespace lacquer::joint_orders_test
