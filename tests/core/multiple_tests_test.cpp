#include "pbrt/core/multiple_tests.h"

#include <gtest/gtest.h>

namespace lacquer::multiple_tests_test {
namespace {

TEST(SidakCritical, OfOneTestIsTheQuantileOfTheTables) {
    // [Abramowitz and Stegun 1964] tables 26.1 and 26.10.
    EXPECT_NEAR(SidakCritical(0.05, 1), 1.959964, 1e-6);
    EXPECT_NEAR(SidakCritical(0.001, 1), 3.290527, 1e-6);
    EXPECT_NEAR(SidakCritical(0.05, 1, 30), 2.042, 6e-4);
    EXPECT_NEAR(SidakCritical(0.05, 1, 60), 2.000, 6e-4);
    EXPECT_NEAR(SidakCritical(0.001, 1, 60), 3.460, 6e-4);
}

TEST(SidakCritical, OfManyTestsHoldsForAllOfThem) {
    for (const size_t n : {2u, 7u, 14u, 200u}) {
        const double z = SidakCritical(0.05, n);
        EXPECT_NEAR(std::pow(1 - TwoSidedNormalP(z), double(n)), 0.95, 1e-9) << n;
        EXPECT_GT(z, SidakCritical(0.05, n - 1));
    }
}

TEST(SidakP, OfTinyProbabilitiesIsTheirSum) {
    EXPECT_NEAR(SidakP(1e-18, 7) / 7e-18, 1, 1e-9);
    EXPECT_EQ(SidakP(0.3, 1), 0.3);
    EXPECT_EQ(SidakP(1, 5), 1);
}

}  // namespace
}  // namespace lacquer::multiple_tests_test
