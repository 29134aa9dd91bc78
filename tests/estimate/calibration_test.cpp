#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "estimate/analytic_simulator.h"
#include "estimate/calibration/simulation_based.h"
#include "estimate/calibration/uniformity.h"
#include "estimate/emulator/emulated_posterior.h"
#include "estimate/infer/mala.h"
#include "estimate/infer/population.h"
#include "support/statistics.h"

namespace lacquer::test::calibration_test {
namespace {

using namespace estimate;

TEST(Uniformity, ChiSquareTailsAreTheTabulatedOnes) {
    EXPECT_NEAR(ChiSquareTail(3.841458820694124, 1), 0.05, 1e-12);
    EXPECT_NEAR(ChiSquareTail(16.918977604620448, 9), 0.05, 1e-12);
    EXPECT_NEAR(ChiSquareTail(2.087900735970686, 9), 0.99, 1e-11);
    for (const double x : {0.1, 2., 10., 60.}) EXPECT_NEAR(ChiSquareTail(x, 2), std::exp(-x / 2), 1e-14);
    EXPECT_EQ(ChiSquareTail(0, 3), 1);
}

TEST(Uniformity, EnvelopesHaveTheirCoverage) {
    // 4000 sets of uniform ranks: 1 % of 4000 is 40 +- 6.3 outside at the most, since counts are whole
    // numbers.
    const EcdfEnvelope envelope(200, 20, 0.99);
    EXPECT_LT(envelope.PointwiseLevel(), 0.01);
    EXPECT_GT(envelope.PointwiseLevel(),
              0.01 / 19);  // points that are neighbours agree: better than a union bound
    Random random(SeedOf("envelopes"));
    int outside = 0, outsideIfNarrow = 0;
    for (int set = 0; set < 4000; ++set) {
        std::vector<int> ranks, narrow;
        for (int i = 0; i < 200; ++i) {
            ranks.push_back(int(random.Index(100)));
            // Draws from a normal posterior 0.75 times as wide as it should be.
            const double z = random.Normal() / 0.75;
            narrow.push_back(std::min(99, int(100 * NormalCdf(z))));
        }
        outside += !envelope.Contains(ranks, 100);
        outsideIfNarrow += !envelope.Contains(narrow, 100);
    }
    EXPECT_GT(outside, 10);
    EXPECT_LT(outside, 65);
    EXPECT_GT(outsideIfNarrow, 2400);  // the power: intervals a quarter too narrow are found
}

/// Draws of a target by a population from `starts`.
Matrix Walked(const Target& target, const Matrix& starts, uint64_t seed) {
    const PopulationWalk walk({.seed = seed, .windowSteps = 30, .numWindows = 5});
    PopulationState state = walk.Start(target, starts);
    walk.Warmup(target, &state);
    return walk.Sample(target, 60, &state).y;
}

Matrix PriorStarts(const Simulator& simulator, uint64_t seed) {
    Matrix starts(2, 33);
    for (Eigen::Index i = 0; i < starts.cols(); ++i) {
        Random random(seed, uint64_t(i));
        starts.col(i) = simulator.Parameters().ToLogit(simulator.Parameters().SamplePrior(random));
    }
    return starts;
}

/// No alarm at 1e-3, so that the tests here together give a false one less than once in a hundred seeds;
/// coverages within three binomial deviations.
void ExpectCalibrated(const CalibrationReport& report) {
    for (const CalibratedParameter& p : report.parameters) {
        EXPECT_GT(p.pValue, 1e-3) << report.ToString();
        EXPECT_NEAR(p.coverage90, 0.9, 0.064) << report.ToString();
        EXPECT_NEAR(p.coverage50, 0.5, 0.106) << report.ToString();
        EXPECT_LT(p.shrinkage, 0.7);  // data do tell something: else every method passes
    }
}
/// Found beyond doubt, and by the rule that reports go by.
void ExpectMiscalibrated(const CalibrationReport& report) {
    double least = 1;
    for (const CalibratedParameter& p : report.parameters) least = std::min(least, p.pValue);
    EXPECT_LT(least, 1e-6) << report.ToString();
    EXPECT_FALSE(report.Passes()) << report.ToString();
}

const AnalyticSimulator& TheSimulator() {
    static const AnalyticSimulator simulator(0.1, 0.15);
    return simulator;
}

CalibrationReport Calibrated(const std::string& name, const InferenceMethod& method, int replicates = 200) {
    return Calibrate(TheSimulator(), method, {.replicates = replicates, .seed = SeedOf(name)});
}

TEST(Calibration, TheExactPosteriorPasses) {
    const CalibrationReport report = Calibrated("exact", [](const Vector& observed, uint64_t seed) {
        return Walked(AnalyticPosterior(TheSimulator(), observed), PriorStarts(TheSimulator(), seed), seed);
    });
    ExpectCalibrated(report);

    // Binomial: .9 +- .021 and .5 +- .035; three of these.
    for (const CalibratedParameter& p : report.parameters) {
        EXPECT_NEAR(p.coverage90, 0.9, 0.064) << report.ToString();
        EXPECT_NEAR(p.coverage50, 0.5, 0.106) << report.ToString();
        EXPECT_LT(p.shrinkage, 0.7);  // data do tell something: else every method passes
    }
}

TEST(Calibration, ACovarianceThatIsTooSmallFails) {
    const CalibrationReport report = Calibrated("narrow", [](const Vector& observed, uint64_t seed) {
        AnalyticPosterior narrow(TheSimulator(), observed);
        narrow.inflation = 0.4;
        return Walked(narrow, PriorStarts(TheSimulator(), seed), seed);
    });
    ExpectMiscalibrated(report);
}

/// One chain of 2000 steps from a draw of the prior, the second half of it.
Matrix ChainDraws(const Sampler& sampler, const Vector& observed, uint64_t seed, bool acceptedOnly) {
    const AnalyticPosterior exact(TheSimulator(), observed);
    std::vector<ChainState> states = {sampler.Start(exact, PriorStarts(TheSimulator(), seed).col(0))};
    const std::vector<Draw> chain = RunChains(sampler, exact, 2000, &states)[0];
    std::vector<Vector> kept;
    for (size_t i = 1000; i < chain.size(); ++i)
        if (chain[i].isAccepted || !acceptedOnly) kept.push_back(chain[i].y);
    if (kept.empty()) kept.push_back(chain.back().y);
    Matrix draws(2, std::max<Eigen::Index>(99, Eigen::Index(kept.size())));
    for (Eigen::Index i = 0; i < draws.cols(); ++i) draws.col(i) = kept[size_t(i) % kept.size()];
    return draws;
}

TEST(Calibration, FrozenAdaptationPasses) {
    const CalibrationReport report = Calibrated("frozen", [](const Vector& observed, uint64_t seed) {
        return ChainDraws(Mala(seed, 1000), observed, seed, false);
    });
    ExpectCalibrated(report);
}

TEST(Calibration, ThePublishedAdaptationFails) {
    // With the setting that was published, from the same starts and with as many gradients.
    const CalibrationReport report = Calibrated("published", [](const Vector& observed, uint64_t seed) {
        return ChainDraws(PublishedMala(seed, 0.005), observed, seed, false);
    });
    ExpectMiscalibrated(report);
}

TEST(Calibration, AcceptedStatesOnlyFail) {
    const CalibrationReport report = Calibrated("accepted", [](const Vector& observed, uint64_t seed) {
        return ChainDraws(PublishedMala(seed, 0.3), observed, seed, true);
    });
    ExpectMiscalibrated(report);
}

TEST(Calibration, TheEmulatedPosteriorPasses) {
    EmulationOptions options;
    options.seed = SeedOf("emulated calibration");
    options.priorRuns = 600;
    options.waves = {{200, 3}, {250, 2}};
    options.maxWaves = 2;
    options.numWalks = 33;
    options.walkSteps = 60;
    const Runs prior = RunPrior(TheSimulator(), options);
    const CalibrationReport report = Calibrated("emulated", [&](const Vector& observed, uint64_t seed) {
        EmulationOptions own = options;
        own.seed = seed;
        return EmulatePosterior(TheSimulator(), observed, prior, own).draws.y;
    });
    ExpectCalibrated(report);

    for (const CalibratedParameter& p : report.parameters)
        EXPECT_NEAR(p.coverage90, 0.9, 0.064) << report.ToString();
}

}  // namespace
}  // namespace lacquer::test::calibration_test
