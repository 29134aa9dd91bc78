#include "support/statistics.h"

#include <vector>

#include "pbrt/core/rng.h"

namespace lacquer::test::statistics_test {
namespace {

TEST(Statistics, ChiSquareSurvivalAtTabulatedPoints) {
    // Upper 5 % and 0.1 % points as in any table.
    EXPECT_NEAR(ChiSquareSurvival(3.841459, 1), 0.05, 1e-7);
    EXPECT_NEAR(ChiSquareSurvival(18.307038, 10), 0.05, 1e-7);
    EXPECT_NEAR(ChiSquareSurvival(149.449253, 100), 0.001, 1e-8);
    EXPECT_NEAR(ChiSquareSurvival(4.605170, 2), 0.1, 1e-7);
    EXPECT_EQ(ChiSquareSurvival(0, 5), 1);
}

TEST(Statistics, NormalAndSidak) {
    EXPECT_NEAR(NormalTwoSided(1.959964), 0.05, 1e-7);
    EXPECT_NEAR(NormalUpper(1.644854), 0.05, 1e-7);
    EXPECT_NEAR(1 - std::pow(1 - SidakAlpha(1e-3, 500), 500), 1e-3, 1e-12);
}

TEST(Statistics, PValuesOfTrueClaimsAreUniform) {
    // 1000 chi-square tests of fair dice: 5 % of them below 0.05, 4 sigma = 2.8 %.
    Rng rng(SeedOf(FullTestName()));
    const std::vector<double> expected(20, 50);
    int below = 0;
    for (int i = 0; i < 1000; ++i) {
        std::vector<double> observed(20);
        for (int k = 0; k < 1000; ++k) ++observed[rng.UniformInt(20)];
        below += ChiSquareTest(observed, expected).pValue < 0.05;
    }
    EXPECT_LT(below, 78);
    EXPECT_GT(below, 5) << "one degree of freedom is given away, so a little fewer than 50 are expected";
}

TEST(Statistics, PoolsEmptyCellsButCountsThem) {
    const std::vector<double> expected = {0, 0, 1, 1, 2, 3, 100}, fits = {0, 0, 1, 0, 3, 3, 100};
    EXPECT_GT(ChiSquareTest(fits, expected).pValue, 0.05);
    const std::vector<double> impossible = {40, 0, 1, 0, 3, 3, 100};
    EXPECT_LT(ChiSquareTest(impossible, expected).pValue, 1e-6);
    EXPECT_LT(ChiSquareTest(std::vector<double>{50}, std::vector<double>{0}).pValue, 1e-6);
}

TEST(Statistics, FailureReportsOtherSeeds) {
    const auto result = Passes("a claim", 0.01, [](uint64_t) { return Outcome{0.001, "what was seen"}; });
    ASSERT_FALSE(result);
    const std::string message = result.message();
    EXPECT_NE(message.find("10 of 10 other seeds"), std::string::npos);
    EXPECT_NE(message.find("what was seen"), std::string::npos);
    EXPECT_TRUE(Passes("a claim", 0.01, [](uint64_t) { return Outcome{0.5, ""}; }));
}

}  // namespace
}  // namespace lacquer::test::statistics_test
