#include "pbrt/lights/windowed_distribution.h"

#include "light_fixtures.h"
#include "support/statistics.h"

namespace lacquer::test::windowed_distribution_test {
namespace {

constexpr int kNx = 7, kNy = 5;

std::vector<float> Values(uint64_t seed) {
    Rng rng(seed);
    std::vector<float> values;
    for (int i = 0; i < kNx * kNy; ++i) values.push_back(rng.Uniform() < 0.2f ? 0.f : rng.Uniform());
    return values;
}

/// Integral over a window, cell by cell.
double Direct(const std::vector<float>& values, const Window& w) {
    double sum = 0;
    for (int y = 0; y < kNy; ++y)
        for (int x = 0; x < kNx; ++x) {
            const double x0 = std::max(double(w.min.x), double(x) / kNx),
                         x1 = std::min(double(w.max.x), double(x + 1) / kNx);
            const double y0 = std::max(double(w.min.y), double(y) / kNy),
                         y1 = std::min(double(w.max.y), double(y + 1) / kNy);
            if (x1 > x0 && y1 > y0) sum += (x1 - x0) * (y1 - y0) * double(values[size_t(y * kNx + x)]);
        }
    return sum;
}

Window RandomWindow(Rng* rng) {
    const Point2 a = rng->Uniform2D(), b = rng->Uniform2D();
    return {glm::min(a, b), glm::max(a, b)};
}

TEST(WindowedDistribution, IntegralsAreSumsOverCells) {
    const std::vector<float> values = Values(SeedOf(FullTestName()));
    const WindowedDistribution distribution(values, kNx, kNy);
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 1000; ++i) {
        const Window w = RandomWindow(&rng);
        EXPECT_NEAR(distribution.Integral(w), Direct(values, w), 1e-12);
    }
    EXPECT_NEAR(distribution.Integral({{0, 0}, {1, 1}}), Direct(values, {{0, 0}, {1, 1}}), 1e-12);
}

/// Chi-square of samples in a 14 x 14 grid over the window against the share of each cell there; `tilt`
/// spoils it.
Outcome SamplesAgainstCells(uint64_t seed, float tilt) {
    constexpr int kGrid = 14, kSamples = 200000;
    Rng rng(seed);
    const std::vector<float> values = Values(seed);
    const WindowedDistribution distribution(values, kNx, kNy);
    const Window w{{0.13f, 0.21f}, {0.81f, 0.93f}};
    const Vec2 extent = w.max - w.min;
    std::vector<double> observed(kGrid * kGrid), expected(kGrid * kGrid);
    for (int y = 0; y < kGrid; ++y)
        for (int x = 0; x < kGrid; ++x) {
            const Point2 a = w.min + extent * (Point2(float(x), float(y)) / float(kGrid));
            expected[size_t(y * kGrid + x)] = kSamples * Direct(values, {a, a + extent / float(kGrid)}) /
                                              Direct(values, w) * (1 + double(tilt) * (x - 6.5) / 6.5);
        }
    for (int i = 0; i < kSamples; ++i) {
        float pdf = 0;
        const auto p = distribution.Sample(rng.Uniform2D(), w, &pdf);
        if (!p || pdf != distribution.Pdf(*p, w)) return {0, "no sample, or one of another density"};
        const glm::ivec2 cell = glm::min(glm::ivec2((*p - w.min) / extent * float(kGrid)), kGrid - 1);
        ++observed[size_t(cell.y * kGrid + cell.x)];
    }
    return ChiSquareTest(observed, expected);
}

TEST(WindowedDistribution, SamplesFollowTheFunctionInsideOfTheWindow) {
    EXPECT_TRUE(Passes(FullTestName(), 1e-4, [](uint64_t seed) { return SamplesAgainstCells(seed, 0); }));
    // Power: a tilt of 3 % has a chi-square excess of about 200000 * 0.03^2 / 3 = 60 at 195 degrees of
    // freedom, which is 3 sigma; 6 % have 240, 12 sigma.
    EXPECT_LT(SamplesAgainstCells(SeedOf(FullTestName()), 0.06f).pValue, 1e-4);
}

TEST(WindowedDistribution, DensityIntegratesToOne) {
    const WindowedDistribution distribution(Values(1), kNx, kNy);
    const Window w{{0.13f, 0.21f}, {0.81f, 0.93f}};
    constexpr int kSteps = 1000;
    double sum = 0;
    for (int y = 0; y < kSteps; ++y)
        for (int x = 0; x < kSteps; ++x)
            sum += double(distribution.Pdf((Point2(float(x), float(y)) + 0.5f) / float(kSteps), w));
    // Steps that straddle an edge of the window are counted in full or not at all: half a step at each side.
    EXPECT_NEAR(sum / (double(kSteps) * kSteps), 1, 4e-3);
}

TEST(WindowedDistribution, EmptyWindowsHaveNoSample) {
    std::vector<float> values(kNx * kNy, 0.f);
    values[0] = 1;
    const WindowedDistribution distribution(values, kNx, kNy);
    float pdf = 0;
    EXPECT_FALSE(distribution.Sample(Point2(0.5f), {{0.5f, 0.5f}, {0.9f, 0.9f}}, &pdf));
    EXPECT_FALSE(distribution.Sample(Point2(0.5f), {{0.1f, 0.1f}, {0.1f, 0.1f}}, &pdf));
    EXPECT_TRUE(distribution.Sample(Point2(0.5f), {{0.f, 0.f}, {0.9f, 0.9f}}, &pdf));
}

}  // namespace
}  // namespace lacquer::test::windowed_distribution_test
