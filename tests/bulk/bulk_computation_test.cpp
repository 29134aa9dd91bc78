#include "bulk/table/bulk_computation.h"

#include <gtest/gtest.h>

#include <numbers>

#include "pbrt/core/parallel.h"
#include "support/bulk_tables.h"
#include "support/statistics.h"

namespace lacquer::test {
namespace {

using namespace bulk;

/// Titania of 125 nm in resin at 550 nm.
BulkSettings Titania(double fraction, BulkMethod method) {
    BulkSettings settings;
    settings.ensemble.species = {{"titania", RadiusDistribution::Constant(0.125), fraction}};
    settings.indices = {OpticalIndex(2.75)};
    settings.hostIndex = 1.5;
    settings.wavelengths = {550};
    settings.method = method;
    return settings;
}

// Computed by another program.
TEST(BulkComputation, PaintWithoutClustersHasTheKnownCoefficients) {
    const BulkTable thin = BulkComputation(Titania(0.001, BulkMethod::Independent)).Table();
    EXPECT_NEAR(thin.sigmaS[0], 25.28, 0.005);
    EXPECT_NEAR(thin.g[0], 0.5736, 5e-5);
    EXPECT_NEAR(thin.sigmaS[0] * (1 - thin.g[0]), 10.78, 0.005);
    EXPECT_EQ(thin.sigmaA[0], 0);
    const double known[][3] = {{0.02, 475.5, 0.552},
                               {0.05, 1084, 0.518},
                               {0.1, 1861, 0.455},
                               {0.2, 2766, 0.306},
                               {0.3, 3200, 0.127}};
    for (const auto& [fraction, sigmaS, g] : known) {
        const BulkTable table = BulkComputation(Titania(fraction, BulkMethod::Structure)).Table();
        EXPECT_NEAR(table.sigmaS[0] / sigmaS, 1, 6e-4) << fraction;
        EXPECT_NEAR(table.g[0], g, 6e-4) << fraction;
        EXPECT_NEAR(NormOfPhase(table.angles, table.phase[0]), 1, 1e-12) << fraction;
        // Control: crowding counts.
        EXPECT_LT(table.sigmaS[0], 0.97 * thin.sigmaS[0] * fraction / 0.001) << fraction;
    }
}

BulkSettings Droplets() {
    BulkSettings settings;
    settings.ensemble.species = {{"fat", RadiusDistribution::LogNormal(0.15, 0.3), 0.02},
                                 {"casein", RadiusDistribution::Constant(0.05), 0.02}};
    settings.ensemble.arrangement = Arrangement::Cut;
    settings.ensemble.count = 8;
    settings.indices = {OpticalIndex(1.46), OpticalIndex({{400, {1.52, 0.02}}, {700, {1.51, 0.01}}})};
    settings.hostIndex = 1.33;
    settings.wavelengths = {450, 550, 650};
    settings.seed = 3;
    return settings;
}

TEST(BulkComputation, TablesDependOnNeitherThreadsNorSteps) {
    const auto text = [](int threads, std::initializer_list<int> steps) {
        const ThreadLimit limit(threads);
        BulkComputation computation(Droplets());
        for (const int step : steps) computation.AddRealizations(step, nullptr);
        EXPECT_EQ(computation.NumRealizations(), 21);
        EXPECT_EQ(computation.NumRefused(), 0);
        EXPECT_LT(computation.WorstEnergyError(), 1e-10);
        return WriteBulkTable(computation.Table());
    };
    const std::string first = text(1, {21});
    EXPECT_EQ(text(2, {21}), first);
    EXPECT_EQ(text(4, {3, 1, 17}), first);
    BulkSettings other = Droplets();
    other.seed = 4;
    BulkComputation control(other);
    control.AddRealizations(21, nullptr);
    EXPECT_NE(WriteBulkTable(control.Table()), first);
}

TEST(BulkComputation, TablesAreWhatScenesRead) {
    for (const AverageMode mode : {AverageMode::Medium, AverageMode::Aggregate}) {
        BulkSettings settings = Droplets();
        settings.mode = mode;
        BulkComputation computation(settings);
        computation.AddRealizations(24, nullptr);
        const BulkTable table = computation.Table();
        const BulkTable read = ReadBulkTable(WriteFile("droplets.json", table));
        EXPECT_EQ(read.mode, mode == AverageMode::Medium ? "medium" : "aggregate");
        ASSERT_EQ(read.phase.size(), 3u);
        for (size_t w = 0; w < 3; ++w) {
            EXPECT_NEAR(read.sigmaS[w] / table.sigmaS[w], 1, 1e-8);
            EXPECT_GT(read.sigmaA[w], 0);
            EXPECT_GT(read.errorSigmaS[w], 0);
        }
    }
}

// Particles so small and so far apart that neither clusters nor their arrangement matter.
TEST(BulkComputation, ClustersOfThinMediaAreIndependent) {
    BulkSettings settings = Droplets();
    settings.ensemble.species = {{"one", RadiusDistribution::Constant(0.1), 4e-4},
                                 {"other", RadiusDistribution::Constant(0.08), 2e-4}};
    settings.indices[0] = OpticalIndex({1.46, 0.01});
    settings.wavelengths = {550};
    settings.mode = AverageMode::Medium;
    BulkComputation clusters(settings);
    clusters.AddRealizations(Scaled(120), nullptr);
    settings.method = BulkMethod::Independent;
    const BulkTable found = clusters.Table(), expected = BulkComputation(settings).Table();
    const double power = 0.1 * std::sqrt(120. / Scaled(120));
    EXPECT_LT(found.errorSigmaS[0], power * expected.sigmaS[0]);
    EXPECT_NEAR(found.sigmaS[0], expected.sigmaS[0], 4 * found.errorSigmaS[0]);
    EXPECT_LT(found.errorSigmaA[0], power * expected.sigmaA[0]);
    EXPECT_NEAR(found.sigmaA[0], expected.sigmaA[0], 4 * found.errorSigmaA[0]);
}

TEST(OpticalIndex, IsLinearBetweenNodesAndConstantBeyond) {
    const OpticalIndex index({{400, {1.5, 0.1}}, {500, {1.7, 0}}});
    EXPECT_EQ(index.At(300), Complex(1.5, 0.1));
    EXPECT_EQ(index.At(600), Complex(1.7, 0));
    EXPECT_LT(std::abs(index.At(425) - Complex(1.55, 0.075)), 1e-12);
}

}  // namespace
}  // namespace lacquer::test
