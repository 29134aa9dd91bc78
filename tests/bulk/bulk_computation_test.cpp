#include "bulk/table/bulk_computation.h"

#include <gtest/gtest.h>

#include <atomic>
#include <numbers>

#include "bulk/table/size_extrapolation.h"
#include "pbrt/core/parallel.h"
#include "support/bulk_tables.h"
#include "support/statistics.h"
#include "support/stopping_observer.h"

namespace lacquer::test::bulk_computation_test {
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
        EXPECT_EQ(computation.NumRealizations(), 9);
        EXPECT_EQ(computation.NumRefused(), 0);
        EXPECT_LT(computation.WorstEnergyError(), 1e-10);
        return WriteBulkTable(computation.Table());
    };
    const std::string first = text(1, {9});
    EXPECT_EQ(text(2, {9}), first);
    EXPECT_EQ(text(4, {3, 1, 5}), first);
    BulkSettings other = Droplets();
    other.seed = 4;
    BulkComputation control(other);
    control.AddRealizations(9, nullptr);
    EXPECT_NE(WriteBulkTable(control.Table()), first);
}

TEST(BulkComputation, GoesOnFromItsStateToTheSameBits) {
    BulkComputation whole(Droplets());
    whole.AddRealizations(11, nullptr);
    BulkComputation first(Droplets());
    first.AddRealizations(6, nullptr);
    const std::vector<double> state = first.State();
    BulkComputation second(Droplets());
    ASSERT_TRUE(second.SetState(state));
    EXPECT_EQ(WriteBulkTable(second.Table()), WriteBulkTable(first.Table()));
    second.AddRealizations(5, nullptr);
    EXPECT_EQ(WriteBulkTable(second.Table()), WriteBulkTable(whole.Table()));
    EXPECT_EQ(second.State(), whole.State());
    // Controls: another number of realisations, another first half, and numbers that are no such state.
    EXPECT_NE(WriteBulkTable(first.Table()), WriteBulkTable(whole.Table()));
    BulkComputation other(Droplets());
    for (const size_t size : {size_t(0), size_t(3), state.size() - 1, state.size() + 1}) {
        std::vector<double> wrong = state;
        wrong.resize(size);
        EXPECT_FALSE(other.SetState(wrong)) << size;
    }
    EXPECT_EQ(other.NumRealizations(), 0);
}

// One sphere in its place is the mean of all its realisations: nothing fluctuates, and what is left is
// rounding.
TEST(BulkComputation, RealizationsThatAreAlikeLeaveNoMedium) {
    BulkSettings settings = Titania(0.01, BulkMethod::Clusters);
    settings.ensemble.arrangement = Arrangement::List;
    settings.ensemble.count = 1;
    settings.ensemble.particles = {{{0, 0, 0}, 0.125, 0}};
    settings.mode = AverageMode::Medium;
    BulkComputation alike(settings);
    alike.AddRealizations(3, nullptr);
    EXPECT_THROW(alike.Table(), SceneError);
    settings.mode = AverageMode::Aggregate;
    BulkComputation aggregate(settings);
    aggregate.AddRealizations(3, nullptr);
    EXPECT_NO_THROW(aggregate.Table());
}

TEST(BulkComputation, KeepsWholeRealisationsWhenItIsStopped) {
    BulkComputation computation(Droplets()), whole(Droplets());
    // In the middle of the third realisation of three wavelengths; threads finish what they have begun.
    const ThreadLimit limit(2);
    StoppingObserver observer(8);
    computation.AddRealizations(10, &observer);
    EXPECT_GE(computation.NumRealizations(), 2);
    EXPECT_LT(computation.NumRealizations(), 8);
    computation.AddRealizations(10 - computation.NumRealizations(), nullptr);
    whole.AddRealizations(10, nullptr);
    EXPECT_EQ(WriteBulkTable(computation.Table()), WriteBulkTable(whole.Table()));
}

TEST(BulkComputation, HistoryEndsAtTheAverage) {
    BulkSettings settings = Droplets();
    settings.wavelengths = {650};
    settings.ensemble.count = 3;
    BulkComputation computation(settings);
    computation.AddRealizations(70, nullptr);
    const std::vector<ConvergencePoint>& history = computation.History(0);
    ASSERT_EQ(history.size(), 63u + 3);  // 2 ... 64, and then every second one
    EXPECT_EQ(history[0].numRealizations, 2);
    EXPECT_EQ(history.back().numRealizations, 70);
    EXPECT_EQ(history.back().scattering.mean, computation.AverageAt(0).scattering.mean);
    EXPECT_EQ(history.back().extinction.error, computation.AverageAt(0).extinction.error);
    EXPECT_EQ(history.back().g.mean, computation.AverageAt(0).g.mean);
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

// Absorption of an index this close to a real one is rounding, which is negative as often as not: scenes
// refuse tables with it, and balls of a medium have no such losses.
TEST(BulkComputation, AbsorptionThatIsRoundingIsNotNegative) {
    BulkSettings settings;
    settings.ensemble.species = {{"a", RadiusDistribution::Constant(0.03), 0.2}};
    settings.ensemble.arrangement = Arrangement::Cut;
    settings.ensemble.count = 3;
    settings.indices = {OpticalIndex(Complex(1.5, 1e-18))};
    settings.wavelengths = {400, 600, 800};
    for (const bool removes : {false, true}) {
        settings.removesMultipleScattering = removes;
        BulkComputation computation(settings);
        computation.AddRealizations(40, nullptr);
        double least = 1;
        for (size_t w = 0; w < 3; ++w) least = std::min(least, computation.AverageAt(w).absorption.mean);
        EXPECT_LT(least, 0) << "a control";
        const BulkTable read = ReadBulkTable(WriteFile("rounding.json", computation.Table()));
        for (size_t w = 0; w < 3; ++w) {
            EXPECT_GE(read.sigmaA[w], 0);
            EXPECT_LT(read.sigmaA[w], 1e-9 * read.sigmaS[w]);
        }
    }
}

// Particles so small and so far apart that neither clusters nor their arrangement matter.
TEST(BulkComputationLong, ClustersOfThinMediaAreIndependent) {
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

TEST(SizeExtrapolation, FindsTheLineAndItsError) {
    const std::vector<double> radii{1, 2, 4};
    // 5 + 3 / R, exact.
    const std::vector<ScatteringAverage::Value> exact{{8, 0.1}, {6.5, 0.2}, {5.75, 0.4}};
    EXPECT_NEAR(ExtrapolateInSize(radii, exact).mean, 5, 1e-12);
    // Two of equal errors e: the value at 0 is 2 y_2 - y_1 for radii 1 and 2, its error sqrt(5) e.
    const auto two = ExtrapolateInSize(std::vector{1., 2.}, std::vector{exact[0], {6.5, 0.1}});
    EXPECT_NEAR(two.mean, 5, 1e-12);
    EXPECT_NEAR(two.error, std::sqrt(5) * 0.1, 1e-12);
    // The weights count: a value that is not known well does not move the line.
    const std::vector<ScatteringAverage::Value> outlier{{8, 0.01}, {6.5, 0.01}, {99, 1e4}};
    EXPECT_NEAR(ExtrapolateInSize(radii, outlier).mean, 5, 0.01);
    // What lies off the line beyond its error makes the error larger.
    const std::vector<ScatteringAverage::Value> bent{{8, 0.1}, {7.5, 0.1}, {5.75, 0.1}},
        straight{{8, 0.1}, {6.5, 0.1}, {5.75, 0.1}};
    EXPECT_GT(ExtrapolateInSize(radii, bent).error, 3 * ExtrapolateInSize(radii, straight).error);
    // An absorption of 0 stays 0.
    const std::vector<ScatteringAverage::Value> none{{0, 0}, {0, 0}, {0, 0}};
    EXPECT_EQ(ExtrapolateInSize(radii, none).mean, 0);
    EXPECT_EQ(ExtrapolateInSize(radii, none).error, 0);
}

TEST(OpticalIndex, IsLinearBetweenNodesAndConstantBeyond) {
    const OpticalIndex index({{400, {1.5, 0.1}}, {500, {1.7, 0}}});
    EXPECT_EQ(index.At(300), Complex(1.5, 0.1));
    EXPECT_EQ(index.At(600), Complex(1.7, 0));
    EXPECT_LT(std::abs(index.At(425) - Complex(1.55, 0.075)), 1e-12);
}

}  // namespace
}  // namespace lacquer::test::bulk_computation_test
