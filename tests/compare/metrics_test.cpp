// Metrics against sums done by hand.
#include "compare/metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace lacquer::compare::metrics_test {
namespace {

/// Two pixels side by side, of channels R and Z.
Image Pair(float r0, float z0, float r1, float z1) {
    Image image({2, 1}, {"R", "Z"});
    image.Pixels() = {r0, z0, r1, z1};
    return image;
}

const Bounds2i kBoth{{0, 0}, {2, 1}};

std::vector<double> Error(const Image& a, const Image& b, Metric metric, const Bounds2i& pixels = kBoth) {
    return ErrorOver(ErrorMap(a, b, metric, b.Channels()), metric, pixels);
}

TEST(Metrics, AreTheMeansOfTheirDefinitions) {
    // Differences: R -1 and 3, Z 0 and 0.5; references: R 2 and 0, Z 7 and 0.5.
    const Image a = Pair(1, 7, 3, 1), b = Pair(2, 7, 0, 0.5f);
    EXPECT_EQ(Error(a, b, Metric::MAE), (std::vector{2.0, 0.25}));
    EXPECT_EQ(Error(a, b, Metric::MSE), (std::vector{5.0, 0.125}));
    EXPECT_FLOAT_EQ(float(Error(a, b, Metric::RMSE)[0]), std::sqrt(5.f));
    const std::vector<double> relative = Error(a, b, Metric::MRSE);
    // The map is of floats: 2^-24 of each term.
    EXPECT_NEAR(relative[0], (1 / 4.01 + 9 / 0.01) / 2, 450 * 1e-7);
    EXPECT_NEAR(relative[1], (0.25 / 0.26) / 2, 1e-7);
}

TEST(Metrics, OnlyTheRelativeOneDependsOnWhichIsTheReference) {
    const Image a = Pair(1, 7, 3, 1), b = Pair(2, 7, 0, 0.5f);
    for (const Metric metric : {Metric::MAE, Metric::MSE, Metric::RMSE})
        EXPECT_EQ(Error(a, b, metric), Error(b, a, metric));
    EXPECT_NE(Error(a, b, Metric::MRSE), Error(b, a, Metric::MRSE));
}

TEST(Metrics, RectangleCountsItsPixelsOnly) {
    const Image a = Pair(1, 7, 3, 1), b = Pair(2, 7, 0, 0.5f);
    EXPECT_EQ(Error(a, b, Metric::RMSE, {{1, 0}, {2, 1}}), (std::vector{3.0, 0.5}));
    EXPECT_EQ(Error(a, b, Metric::RMSE, {{0, 0}, {1, 1}}), (std::vector{1.0, 0.0}));
}

TEST(Metrics, ChannelsAreFoundByName) {
    Image swapped({2, 1}, {"Z", "R"});
    swapped.Pixels() = {7, 1, 1, 3};
    const Image b = Pair(2, 7, 0, 0.5f);
    const Image map = ErrorMap(swapped, b, Metric::MAE, {"R"});
    EXPECT_EQ(map.Channels(), std::vector<std::string>{"R"});
    EXPECT_EQ(map.Pixels(), (std::vector{1.f, 3.f}));
}

TEST(Metrics, NotFiniteIsNeverAMean) {
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    const Image good = Pair(1, 1, 1, 1);
    for (const Metric metric : {Metric::MAE, Metric::MSE, Metric::MRSE, Metric::RMSE}) {
        EXPECT_TRUE(std::isnan(Error(Pair(1, 1, nan, 1), good, metric)[0]));
        EXPECT_TRUE(std::isnan(Error(good, Pair(1, 1, nan, 1), metric)[0]));
        EXPECT_FALSE(std::isfinite(Error(Pair(inf, 1, 1, 1), good, metric)[0]));
        // Both infinite: no difference that one could name.
        EXPECT_FALSE(std::isfinite(Error(Pair(inf, 1, 1, 1), Pair(inf, 1, 1, 1), metric)[0]));
        EXPECT_EQ(Error(Pair(inf, 1, 1, 1), good, metric)[1], 0);
    }
}

TEST(Metrics, NonFiniteValuesAreCountedAndPlaced) {
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    const NonFinite found = FindNonFinite(Pair(1, nan, -inf, nan), {"R", "Z"});
    EXPECT_EQ(found.nan, 2);
    EXPECT_EQ(found.inf, 1);
    EXPECT_EQ(found.pixel, Int2(0, 0));
    EXPECT_EQ(found.channel, "Z");
    EXPECT_EQ(FindNonFinite(Pair(1, nan, -inf, nan), {"R"}).pixel, Int2(1, 0));
    EXPECT_FALSE(FindNonFinite(Pair(1, nan, 2, nan), {"R"}).Any());
}

TEST(Metrics, NamesAreParsedBack) {
    for (const std::string& name : MetricNames()) EXPECT_TRUE(ParseMetric(name)) << name;
    EXPECT_FALSE(ParseMetric("PSNR"));
}

}  // namespace
}  // namespace lacquer::compare::metrics_test
