// Draws from interpolated tables.
#include "pbrt/bxdfs/bilinear_warp.h"

#include <gtest/gtest.h>

#include "pbrt/core/rng.h"
#include "support/statistics.h"

namespace lacquer::test::bilinear_warp_test {
namespace {

constexpr size_t kRows = 4, kColumns = 5, kSlices = 6;

/// Random tables: three nodes of one parameter times two of another. The last one is black.
std::vector<float> Tables() {
    Rng rng(SeedOf("BilinearWarp"));
    std::vector<float> values(kRows * kColumns * kSlices);
    for (float& v : values) v = std::max(0.f, rng.Uniform() - 0.2f);
    for (size_t i = values.size() - kRows * kColumns; i < values.size(); ++i) values[i] = 0;
    return values;
}
SliceBlend BlendAt(float a, float b) {
    const float first[] = {0, 1, 4}, second[] = {-1, 1};
    return SliceBlend().Refined(first, a).Refined(second, b);
}
const BilinearWarp& Warp() {
    static const BilinearWarp warp(Tables(), kRows, kColumns);
    return warp;
}

TEST(SliceBlend, InterpolatesLinearlyAndStopsAtTheEnds) {
    for (const auto& [a, b] : {std::pair(0.5f, 0.f), {2.f, 0.5f}, {-3.f, 7.f}, {4.f, -1.f}}) {
        const SliceBlend blend = BlendAt(a, b);
        float sum = 0, meanFirst = 0, meanSecond = 0;
        for (int k = 0; k < blend.count; ++k) {
            const float first[] = {0, 1, 4}, second[] = {-1, 1};
            sum += blend.weight[k];
            meanFirst += blend.weight[k] * first[blend.slice[k] / 2];
            meanSecond += blend.weight[k] * second[blend.slice[k] % 2];
        }
        EXPECT_NEAR(sum, 1, 1e-6f);
        EXPECT_NEAR(meanFirst, std::clamp(a, 0.f, 4.f), 1e-5f);
        EXPECT_NEAR(meanSecond, std::clamp(b, -1.f, 1.f), 1e-6f);
    }
    const float one[] = {3};
    EXPECT_EQ(SliceBlend().Refined(one, 17).count, 1);
}

TEST(BilinearTables, PassThroughTheirSamples) {
    const std::vector<float> values = {1, 2, 4, 3, 0, 5};
    const BilinearTables tables(values, 2, 3);
    EXPECT_FLOAT_EQ(tables.Evaluate({0.5f, 1}, {}), 0);
    EXPECT_FLOAT_EQ(tables.Evaluate({1, 0}, {}), 4);
    EXPECT_FLOAT_EQ(tables.Evaluate({0.25f, 0.5f}, {}), 1.5f);
    EXPECT_FLOAT_EQ(tables.Evaluate({2, -1}, {}), 4);  // the nearest point of the square
}

TEST(BilinearWarp, InvertUndoesSample) {
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 2000; ++i) {
        const SliceBlend blend = BlendAt(5 * rng.Uniform() - 0.5f, 3 * rng.Uniform() - 1.5f);
        const Point2 u = rng.Uniform2D();
        const BilinearWarp::Point drawn = Warp().Sample(u, blend), back = Warp().Invert(drawn.p, blend);
        EXPECT_NEAR(back.p.x, u.x, 2e-4f);
        EXPECT_NEAR(back.p.y, u.y, 2e-4f);
        EXPECT_NEAR(back.pdf, drawn.pdf, 1e-3f * (1 + drawn.pdf));
        EXPECT_NEAR(Warp().Pdf(drawn.p, blend), drawn.pdf, 1e-3f * (1 + drawn.pdf));
    }
}

TEST(BilinearWarp, CornersStayInTheSquare) {
    for (const float x : {0.f, 0x1p-24f, OneMinusEpsilon})
        for (const float y : {0.f, 0x1p-24f, OneMinusEpsilon})
            for (const float a : {0.f, 0.5f, 4.f}) {
                const BilinearWarp::Point drawn = Warp().Sample({x, y}, BlendAt(a, 1));
                EXPECT_TRUE(drawn.p.x >= 0 && drawn.p.x <= 1 && drawn.p.y >= 0 && drawn.p.y <= 1);
                EXPECT_TRUE(std::isfinite(drawn.pdf) && drawn.pdf >= 0);
            }
}

/// Draws in 8 x 8 cells against integrals of the density (midpoints of 16 x 16 parts) of perhaps another
/// blend.
Outcome CompareSamples(const SliceBlend& drawn, const SliceBlend& expected, uint64_t seed) {
    constexpr int kCells = 8, kParts = 16, kSamples = 100000;
    std::vector<double> counts(kCells * kCells, 0.), expectations(counts);
    Rng rng(seed);
    for (int i = 0; i < kSamples; ++i) {
        const Point2 p = Warp().Sample(rng.Uniform2D(), drawn).p;
        ++counts[size_t(std::min(int(p.y * kCells), kCells - 1) * kCells +
                        std::min(int(p.x * kCells), kCells - 1))];
    }
    for (int y = 0; y < kCells * kParts; ++y)
        for (int x = 0; x < kCells * kParts; ++x) {
            const Point2 p = (Point2(x, y) + 0.5f) / float(kCells * kParts);
            expectations[size_t(y / kParts * kCells + x / kParts)] +=
                double(Warp().Pdf(p, expected)) * kSamples / Sqr(double(kCells * kParts));
        }
    return ChiSquareTest(counts, expectations);
}

// Power: at 100,000 draws in 64 cells, densities that differ by 2 % (rms) are found (non-centrality 40).
TEST(BilinearWarp, DrawsWithItsDensity) {
    for (const auto& [a, b] : {std::pair(0.f, -1.f), {0.4f, 0.2f}, {3.f, 0.9f}})
        EXPECT_TRUE(
            Passes(FullTestName() + std::to_string(a), 1e-4, [&, first = a, second = b](uint64_t seed) {
                return CompareSamples(BlendAt(first, second), BlendAt(first, second), seed);
            }));
}
TEST(BilinearWarpControl, DrawsOfAnotherBlendAreFound) {
    EXPECT_LT(CompareSamples(BlendAt(0.4f, 0.2f), BlendAt(0.6f, 0.2f), SeedOf(FullTestName())).pValue, 1e-4);
}

TEST(BilinearWarp, BlackTablesAreUniform) {
    SliceBlend last;
    last.slice[0] = kSlices - 1;
    EXPECT_FLOAT_EQ(Warp().Pdf({0.3f, 0.9f}, last), 1);
    const Point2 p = Warp().Sample({0.3f, 0.9f}, last).p;
    EXPECT_NEAR(p.x, 0.3f, 1e-6f);
    EXPECT_NEAR(p.y, 0.9f, 1e-6f);
}

}  // namespace
}  // namespace lacquer::test::bilinear_warp_test
