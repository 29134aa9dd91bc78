// Sets of points beside the samplers' own dimensions.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "pbrt/base/sampler.h"
#include "support/statistics.h"

namespace lacquer::point_sets_test {
namespace {

using namespace lacquer::test;

constexpr size_t kDimensions = LeadingNumbers::kBlock;

std::unique_ptr<Sampler> Make(const std::string& name, int samples) {
    const Params params("sampler \"" + name + "\"", {}, {}, nullptr);
    return Registry<SamplerKind>::Find(name)({params, {64, 64}, samples, 0, nullptr});
}
LeadingNumbers::Block PointOf(Sampler& sampler, Int2 pixel, int index, const PointSet& set) {
    LeadingNumbers::Block x{};
    sampler.StartPixelSample(pixel, index);
    EXPECT_TRUE(sampler.GetPoint(set, &x));
    return x;
}
size_t CellOf(float x, int cells) { return size_t(x * float(cells)); }

TEST(PointSets, IndependentSamplerKnowsNone) {
    const auto sampler = Make("independent", 16);
    sampler->StartPixelSample({0, 0}, 0);
    LeadingNumbers::Block x;
    EXPECT_FALSE(sampler->GetPoint({}, &x));
}

// Each dimension has one of 2^k points in each of 2^k intervals, for every k: the sequence goes on.
TEST(PointSets, EachDimensionIsStratified) {
    for (const char* name : {"halton", "paddedsobol", "pmj02bn", "sobol", "stratified", "zsobol"}) {
        const auto sampler = Make(name, 64);
        for (const int count : {4, 16, 64})
            for (size_t d = 0; d < kDimensions; ++d) {
                std::vector<int> seen(size_t(count), 0);
                for (int i = 0; i < count; ++i)
                    ++seen[CellOf(PointOf(*sampler, {3, 5}, i, {7, 0, 1})[d], count)];
                EXPECT_EQ(seen, std::vector<int>(size_t(count), 1)) << name << " " << d;
            }
    }
}
// Several points of a sample are those of so many samples.
TEST(PointSets, CopiesAreStratifiedTogether) {
    const auto sampler = Make("paddedsobol", 16);
    std::vector<int> seen(64, 0);
    for (int i = 0; i < 16; ++i)
        for (uint32_t copy = 0; copy < 4; ++copy)
            ++seen[CellOf(PointOf(*sampler, {3, 5}, i, {7, copy, 4})[5], 64)];
    EXPECT_EQ(seen, std::vector<int>(64, 1));
}

/// Chi-square of pairs (x, y) of numbers in an 8 x 8 grid.
template <class Pair>
Outcome TestIndependence(int count, const Pair& pair) {
    constexpr int kCells = 8;
    std::vector<double> observed(kCells * kCells, 0), expected(kCells * kCells, double(count) / 64);
    for (int i = 0; i < count; ++i) {
        const Point2 p = pair(i);
        observed[CellOf(p.x, kCells) * kCells + CellOf(p.y, kCells)] += 1;
    }
    return ChiSquareTest(observed, expected);
}
/// Of one sample in many pixels: only the scrambles differ.
Outcome TestSets(Sampler& sampler, const PointSet& a, size_t dimensionA, const PointSet& b, size_t dimensionB,
                 uint64_t seed) {
    const int index = int(seed % 16);
    return TestIndependence(Scaled(40000), [&](int i) {
        const Int2 pixel{i % 256, i / 256 + int(Hash(seed) % 100000)};
        return Point2(PointOf(sampler, pixel, index, a)[dimensionA],
                      PointOf(sampler, pixel, index, b)[dimensionB]);
    });
}
TEST(PointSets, ScramblesAreUniformAndSetsIndependent) {
    const auto sampler = Make("paddedsobol", 16);
    for (size_t d = 0; d < kDimensions; ++d) {
        const auto check = [&](const PointSet& other, size_t otherDimension) {
            return Passes(FullTestName() + std::to_string(d), SidakAlpha(1e-3, 24), [&](uint64_t seed) {
                return TestSets(*sampler, {256, 0, 1}, d, other, otherDimension, seed);
            });
        };
        EXPECT_TRUE(check({256, 0, 1}, (d + 1) % kDimensions));
        EXPECT_TRUE(check({257, 0, 1}, d));
        EXPECT_TRUE(check({512, 0, 1}, d));
    }
}
// Two sets of one pixel as the samples go on: a shuffle of its own for each set. Pairs of one set are
// stratified, which the same test sees, the other way.
TEST(PointSets, SamplesOfTwoSetsArePaired) {
    const auto sampler = Make("paddedsobol", 64);
    const auto pairs = [&](uint64_t keyB) {
        return TestIndependence(Scaled(40000), [&](int i) {
            const Int2 pixel{i / 64 % 64, i / 4096};
            return Point2(PointOf(*sampler, pixel, i % 64, {256, 0, 1})[3],
                          PointOf(*sampler, pixel, i % 64, {keyB, 0, 1})[3]);
        });
    };
    EXPECT_GT(pairs(257).pValue, 1e-3);
    EXPECT_LT(pairs(256).pValue, 1e-6) << "the control: the set with itself";
}

}  // namespace
}  // namespace lacquer::point_sets_test
