#include "cmd/bulk/bulk_plan.h"

#include <gtest/gtest.h>

namespace lacquer::test::bulk_plan_test {
namespace {

using namespace bulk;
using namespace cmd;

BulkSettings Droplets(int numWavelengths) {
    BulkSettings settings;
    settings.ensemble.species = {{"fat", RadiusDistribution::Constant(0.25), 0.03}};
    settings.ensemble.count = 20;
    settings.indices = {OpticalIndex(1.46)};
    settings.hostIndex = 1.33;
    for (int i = 0; i < numWavelengths; ++i) settings.wavelengths.push_back(550 + 0.01 * i);
    return settings;
}

// Of more than three wavelengths some are measured, for all: the least of a few measurements is within a
// factor of two of as many times one wavelength, on a busy machine too. Three times as much, and nothing, are
// found.
TEST(BulkPlanLong, TimesOfManyWavelengthsAreThoseOfAll) {
    const auto seconds = [](int numWavelengths) {
        const BulkSettings settings = Droplets(numWavelengths);
        BulkPlan plan = PlanOf(settings);
        double least = 1e9;
        for (int i = 0; i < 12; ++i) {
            MeasureTime(settings, &plan);
            least = std::min(least, plan.secondsPerRealization);
        }
        return least;
    };
    const double one = seconds(1);
    EXPECT_GT(one, 0);
    for (const int n : {2, 3, 7, 10}) {
        const double ratio = seconds(n) / (n * one);
        EXPECT_GT(ratio, 0.5) << n;
        EXPECT_LT(ratio, 2) << n;
    }
}

}  // namespace
}  // namespace lacquer::test::bulk_plan_test
