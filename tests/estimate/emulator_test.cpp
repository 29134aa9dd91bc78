#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "estimate/analytic_simulator.h"
#include "estimate/covariance/projection.h"
#include "estimate/covariance/regression_summaries.h"
#include "estimate/covariance/shrinkage.h"
#include "estimate/diagnostics/convergence.h"
#include "estimate/emulator/emulated_posterior.h"
#include "estimate/emulator/model_check.h"
#include "estimate/emulator/regression_coordinates.h"
#include "estimate/infer/whitened_hmc.h"
#include "estimate/photo_simulator.h"
#include "pbrt/core/error.h"
#include "pbrt/core/parallel.h"
#include "support/statistics.h"

namespace lacquer::test::emulator_test {
namespace {

using namespace estimate;

Matrix NormalRows(const std::string& name, Eigen::Index rows, Eigen::Index columns) {
    Random random(SeedOf(name));
    Matrix m(rows, columns);
    for (double& value : m.reshaped()) value = random.Normal();
    return m;
}

TEST(Shrinkage, IndependentSummariesLoseTheirChanceCorrelations) {
    // 50 simulations of 40 independent summaries: chance correlations of .14 each make the plain inverse
    // useless.
    const Matrix samples = NormalRows("independent", 50, 40);
    const ShrunkCovariance shrunk = ShrinkCorrelations(samples, 50);
    EXPECT_GT(shrunk.intensity, 0.8);
    EXPECT_LT((shrunk.covariance - Matrix(shrunk.covariance.diagonal().asDiagonal())).cwiseAbs().maxCoeff(),
              0.2);
}

TEST(Shrinkage, ManySimulationsKeepTheCorrelationsThatAreThere) {
    Matrix samples = NormalRows("correlated", 5000, 6);
    for (Eigen::Index j = 5; j > 0; --j)
        samples.col(j) = 3 * (0.8 * samples.col(j - 1) + 0.6 * samples.col(j));
    const ShrunkCovariance shrunk = ShrinkCorrelations(samples, 5000);
    EXPECT_LT(shrunk.intensity, 0.02);
    const Matrix plain = samples.transpose() * samples / 5000;
    EXPECT_LT((shrunk.covariance - plain).cwiseAbs().maxCoeff() / plain.cwiseAbs().maxCoeff(), 0.02);
}

TEST(Shrinkage, HartlapsFactorMakesTheInverseUnbiased) {
    // Mean of the inverse of covariances from 20 samples of 6 independent summaries: (n - p - 1) / n of it
    // is 1.
    RunningMean plain;
    for (int i = 0; i < 2000; ++i) {
        const Matrix samples = NormalRows(fmt::format("hartlap {}", i), 20, 6);
        const Matrix inverse = (samples.transpose() * samples / 20).inverse();
        for (double value : inverse.diagonal()) plain.Add(value);
    }
    EXPECT_NEAR(plain.Mean() * HartlapFactor(20, 6), 1, 5 * plain.StandardError());
    EXPECT_GT(plain.Mean(), 1.4);  // without the factor
}

TEST(Shrinkage, TheStudentLikelihoodIsThatOfAnUnknownCovariance) {
    // For one summary the t density is a closed form; its derivative is that of differences.
    const ResidualLikelihood student({Matrix::Constant(1, 1, 4.), 0}, 7, CovarianceError::Student);
    EXPECT_NEAR(student.Misfit(Vector::Constant(1, 6)), 9, 1e-12);
    double slope = 0;
    EXPECT_NEAR(student.LogOfMisfit(9, &slope), -4 * std::log(1 + 9. / 7), 1e-12);
    EXPECT_NEAR(slope, (student.LogOfMisfit(9 + 1e-6) - student.LogOfMisfit(9 - 1e-6)) / 2e-6, 1e-8);
}

TEST(SummaryProjection, ManySummariesBecomeTheirComponents) {
    // 200 summaries of three hidden numbers and a little noise.
    const Matrix hidden = NormalRows("hidden", 120, 3), loading = NormalRows("loading", 3, 200);
    const Matrix summaries = hidden * loading + 1e-6 * NormalRows("noise", 120, 200);
    const SummaryProjection projection(summaries);
    EXPECT_EQ(projection.Size(), 3);
    const Vector ofRow = projection.ApplyToRows(summaries).row(7);
    EXPECT_LT((ofRow - projection.Apply(summaries.row(7))).norm(), 1e-9);
    EXPECT_EQ(SummaryProjection(NormalRows("few", 120, 20)).Size(), 20);
}

TEST(RegressionSummaries, LeftOutPredictionsAreThoseOfRegressionsWithoutTheRow) {
    constexpr Eigen::Index kRows = 40, kColumns = 4;
    const Matrix summaries = NormalRows("left out", kRows, kColumns);
    const Matrix parameters = summaries * NormalRows("left out slopes", kColumns, 2) +
                              1e-3 * NormalRows("left out noise", kRows, 2);
    const RegressionSummaries regression(summaries, parameters);
    double largest = 0;
    for (Eigen::Index row = 0; row < kRows; ++row) {
        // With a column of ones; without the row.
        Matrix design(kRows, kColumns + 1);
        design << Vector::Ones(kRows), summaries;
        const Vector there = design.row(row);
        design.row(row).setZero();
        Matrix values = parameters;
        values.row(row).setZero();
        const Matrix coefficients = (design.transpose() * design).inverse() * design.transpose() * values;
        const Vector expected =
            coefficients.transpose() * there - Vector(parameters.colwise().mean().transpose());
        // The ridge is at least 1e-7 of a regression whose errors are 1e-3 of its values.
        EXPECT_LT((regression.LeftOut().row(row).transpose() - expected).cwiseAbs().maxCoeff(), 1e-5);
        largest = std::max(largest, (regression.Apply(summaries.row(row)) - expected).cwiseAbs().maxCoeff());
    }
    EXPECT_GT(largest, 1e-4);  // the control: what has been fitted to the row as well
}

TEST(RegressionSummaries, WhatHasBeenFittedLooksBetterThanItIs) {
    // 100 summaries that tell nothing, of 150 simulations.
    const Matrix summaries = NormalRows("nothing", 150, 100), parameters = NormalRows("of nothing", 150, 1);
    const RegressionSummaries regression(summaries, parameters);
    const Matrix news = NormalRows("new nothing", 1000, 100);
    double squares = 0;
    for (Eigen::Index i = 0; i < news.rows(); ++i)
        squares += regression.Apply(news.row(i)).squaredNorm() / double(news.rows());
    const double leftOut = regression.LeftOut().squaredNorm() / 150;
    EXPECT_LT(std::abs(regression.LeftOut().col(0).dot(parameters.col(0))) / 150, 0.2);
    EXPECT_LT(squares, 0.2);
    EXPECT_LT(leftOut, 0.2);
}

TEST(RegressionSummaries, ConstantSummariesHaveNoPart) {
    Matrix summaries = NormalRows("constants", 60, 3);
    const Matrix parameters = summaries.col(0) + 0.1 * NormalRows("constant noise", 60, 1);
    const Vector without = RegressionSummaries(summaries, parameters).Apply(Vector::Ones(3));
    // One that never changes but for the rounding of sums, and one that is 0.
    Matrix more(60, 5);
    more << summaries, Matrix::Constant(60, 1, -7.3), Matrix::Zero(60, 1);
    more(5, 3) *= 1 + 1e-15;
    Vector observed = Vector::Ones(5);
    EXPECT_NEAR(RegressionSummaries(more, parameters).Apply(observed)[0], without[0], 1e-12);
}

TEST(PolynomialBasis, AFewLinearMeansNeedNoSquares) {
    // 8 parameters have 36 squares and products, which add their errors where they are not needed.
    const Matrix points = NormalRows("linear points", 8, 150);
    const Matrix slopes = NormalRows("linear slopes", 8, 5);
    const Matrix means = points.transpose() * slopes;
    const Matrix values = means + NormalRows("linear noise", 150, 5);
    PolynomialBasis with(points, 2);
    const PolynomialBasis without(points, 2);
    with.ChooseRidge(values);
    const auto error = [&](const PolynomialBasis& basis) {
        return (basis.TermsOfRuns() * basis.Fit(values) - means).squaredNorm() / double(means.size());
    };
    EXPECT_LT(error(with), 0.5 * error(without));
    EXPECT_LT(with.NumFree(), 20);
    EXPECT_NEAR(without.NumFree(), 45, 1e-6);
    // Where squares are there, they stay.
    PolynomialBasis curved(points, 2);
    curved.ChooseRidge(values + 3 * points.cwiseAbs2().transpose() * slopes);
    EXPECT_GT(curved.NumFree(), 35);
}

TEST(RegressionCoordinates, ArePriorsRanksAndRootsOfProducts) {
    Parameter light{"light", "cm^2", {1000, 400, 1, 2500}}, r{"r", "", {.4, .3, 0, 1}};
    r.productWith = "light";
    // The last one is cut to the upper tail.
    const ParameterSpace space({light, r, {"fsx", "", {.05, .05, .001, .2}}, {"tail", "", {0, 1, 3, 9}}});
    const RegressionCoordinates coordinates(space);
    constexpr Eigen::Index kDraws = 4000;
    Matrix draws(4, kDraws);
    for (Eigen::Index i = 0; i < kDraws; ++i) {
        Random random(SeedOf("coordinates"), uint64_t(i));
        draws.col(i) = space.ToLogit(space.SamplePrior(random));
    }
    const Matrix t = coordinates.FromLogits(draws);
    for (const Eigen::Index i : {0, 2, 3}) {
        // Mean, variance and fourth moment of the standard normal distribution, to four errors.
        EXPECT_NEAR(t.row(i).mean(), 0, 4 / std::sqrt(double(kDraws))) << i;
        EXPECT_NEAR(t.row(i).squaredNorm() / kDraws, 1, 4 * std::sqrt(2. / kDraws)) << i;
        EXPECT_NEAR(t.row(i).array().pow(4).mean(), 3, 4 * std::sqrt(96. / kDraws)) << i;
    }
    // The control: logits of a prior with mass at its bound have a long tail.
    const auto logits = draws.row(2).array() - draws.row(2).mean();
    EXPECT_GT(logits.pow(4).mean() / std::pow(logits.square().mean(), 2), 3.5);
    const Vector y = draws.col(5), x = space.ToNatural(y), weights = Eigen::Vector4d(1, 2, 3, 4);
    EXPECT_NEAR(t(1, 5), std::sqrt(x[0] * x[1]), 1e-9 * t(1, 5));
    const Vector gradient = coordinates.GradientByLogits(y, weights);
    for (Eigen::Index i = 0; i < 4; ++i) {
        Matrix ends(4, 2);
        ends.col(0) = ends.col(1) = y;
        ends(i, 0) -= 1e-5;
        ends(i, 1) += 1e-5;
        const Matrix there = coordinates.FromLogits(ends);
        EXPECT_NEAR(gradient[i], weights.dot(there.col(1) - there.col(0)) / 2e-5,
                    1e-6 * (1 + std::abs(gradient[i])));
    }
}

/// Runs of the analytic simulator over its prior.
Runs AnalyticRuns(const AnalyticSimulator& simulator, Eigen::Index count) {
    EmulationOptions options;
    options.priorRuns = count;
    options.seed = SeedOf("analytic runs");
    return RunPrior(simulator, options);
}

TEST(SummaryEmulator, GradientsAreDifferences) {
    const AnalyticSimulator simulator(0.2, 0.3);
    const Runs runs = AnalyticRuns(simulator, 300);
    for (const CovarianceError error : {CovarianceError::Hartlap, CovarianceError::Student})
        for (const int degree : {1, 2, 3}) {
            const SummaryEmulator emulator(
                runs.parameters, runs.summaries,
                {.degree = degree, .hasVaryingVariance = true, .covarianceError = error});
            const Vector observed = emulator.Project(runs.summaries.row(3));
            for (Eigen::Index i = 0; i < 5; ++i) {
                // The last two lie beyond all simulations.
                const Vector y = (i < 3 ? 1 : 4) * runs.parameters.col(i);
                Vector gradient;
                constexpr double kInflation = 1.7;
                emulator.LogLikelihood(y, observed, &gradient, kInflation);
                for (Eigen::Index k = 0; k < 2; ++k) {
                    Vector high = y, low = y;
                    high[k] += 1e-5;
                    low[k] -= 1e-5;
                    const double difference = (emulator.LogLikelihood(high, observed, nullptr, kInflation) -
                                               emulator.LogLikelihood(low, observed, nullptr, kInflation)) /
                                              2e-5;
                    EXPECT_NEAR(gradient[k], difference, 1e-6 * (1 + std::abs(difference))) << degree;
                }
            }
        }
}

TEST(SummaryEmulator, LearnsTheLikelihoodWithItsVaryingScatter) {
    const AnalyticSimulator simulator(0.2, 0.3);
    const Runs runs = AnalyticRuns(simulator, 4000);
    const SummaryEmulator varying(runs.parameters, runs.summaries, {.hasVaryingVariance = true});
    const SummaryEmulator constant(runs.parameters, runs.summaries, {.hasVaryingVariance = false});
    const Vector observed = simulator.Simulate(Eigen::Vector2d(0.4, 5), SeedOf("observed"));
    const AnalyticPosterior exact(simulator, observed);
    // Differences of log likelihoods between points of the prior's middle, in tenths of themselves and at
    // least of 2: what decides about points near the best one must be right, what rules others out may be off
    // by a part.
    double worst = 0, worstConstant = 0;
    const Vector from = Vector::Zero(2);
    const auto error = [&](const SummaryEmulator& emulator, const Vector& y) {
        const auto exactly = [&](const Vector& at) {
            return exact.LogDensity(at, nullptr) - simulator.Parameters().LogPriorOfLogit(at);
        };
        const auto learnt = [&](const Vector& at) {
            return emulator.LogLikelihood(at, emulator.Project(observed));
        };
        const double difference = exactly(y) - exactly(from);
        return std::abs(learnt(y) - learnt(from) - difference) / (0.5 + 0.05 * std::abs(difference));
    };
    for (double a = -1; a <= 1; a += 0.5)
        for (double b = -1; b <= 1; b += 0.5) {
            worst = std::max(worst, error(varying, Eigen::Vector2d(a, b)));
            worstConstant = std::max(worstConstant, error(constant, Eigen::Vector2d(a, b)));
        }
    EXPECT_LT(worst, 1);
    EXPECT_GT(worstConstant, 5);  // the control: scatter that fans out by e^.9 in this square
}

TEST(SummaryEmulator, FallsOffWhereThereAreNoSimulations) {
    // Few simulations of a curved mean: the error of the polynomials flattens the likelihood out there.
    const AnalyticSimulator simulator(0.2, 0.3);
    const Runs runs = AnalyticRuns(simulator, 60);
    const SummaryEmulator emulator(runs.parameters, runs.summaries, {});
    const Vector observed = emulator.Project(simulator.Simulate(Eigen::Vector2d(0.4, 5), 1));
    const double inside = emulator.LogLikelihood(Vector::Zero(2), observed);
    for (int k = 0; k < 12; ++k) {
        const double angle = k * 0.5236;
        const Vector y = 12 * Eigen::Vector2d(std::cos(angle), std::sin(angle));
        EXPECT_LT(emulator.LogLikelihood(y, observed), inside - 10) << k;
    }
}

TEST(EmulatedPosterior, AgreesWithTheExactOne) {
    const AnalyticSimulator simulator(0.15, 0.2);
    EmulationOptions options;
    options.emulator.hasVaryingVariance = true;
    options.seed = SeedOf("emulated");
    options.walkSteps = 1000;
    const Runs prior = RunPrior(simulator, options);
    RunningMean means, ratios;
    for (uint64_t trial = 0; trial < 6; ++trial) {
        Random random(SeedOf("truth"), trial);
        const Vector truth = simulator.Parameters().SamplePrior(random);
        const Vector observed = simulator.Simulate(truth, random.Bits());
        const EmulatedPosterior emulated = EmulatePosterior(simulator, observed, prior, options);
        const AnalyticPosterior exact(simulator, observed);
        const PopulationWalk walk({.seed = trial});
        PopulationState state = walk.Start(exact, emulated.draws.y.leftCols(80));
        walk.Warmup(exact, &state);
        const PopulationDraws draws = walk.Sample(exact, 2000, &state);
        for (Eigen::Index i = 0; i < 2; ++i) {
            const double sd = std::sqrt(CovarianceOfColumns(draws.y)(i, i));
            const double shift = (emulated.draws.y.row(i).mean() - draws.y.row(i).mean()) / sd;
            const double ratio = std::sqrt(CovarianceOfColumns(emulated.draws.y)(i, i)) / sd;
            EXPECT_LT(std::abs(shift), 0.4) << trial << " " << i;
            EXPECT_NEAR(ratio, 1, 0.25) << trial << " " << i;
            means.Add(shift);
            ratios.Add(ratio);
        }
        EXPECT_LT(emulated.waves.back().maxRhat, 1.05);
    }
    EXPECT_NEAR(means.Mean(), 0, 0.1);
    EXPECT_NEAR(ratios.Mean(), 1, 0.1);
}

TEST(EmulatedPosterior, ChainsOnItConvergeAndAgreeWithTheWalks) {
    const AnalyticSimulator simulator(0.15, 0.1);
    EmulationOptions options;
    options.priorRuns = 400;
    options.waves = {{150, 3}, {150, 2}};
    options.maxWaves = 2;
    options.walkSteps = 600;
    const Vector observed = simulator.Simulate(Eigen::Vector2d(0.6, 6), 11);
    const EmulatedPosterior posterior =
        EmulatePosterior(simulator, observed, RunPrior(simulator, options), options);
    const WhitenedHmc hmc(*posterior.target, posterior.draws.y, SeedOf("chains"), 300);
    std::vector<ChainState> states = hmc.Start(4);
    const auto chains = hmc.Run(2300, &states);
    for (Eigen::Index i = 0; i < 2; ++i) {
        const Matrix draws = CoordinateOf(chains, 300, i);
        const double sd = std::sqrt(CovarianceOfColumns(posterior.draws.y)(i, i));
        // What walks and chains draw from is the same: means to three errors of 80 walks of about 20 draws
        // each.
        EXPECT_NEAR(draws.mean(), posterior.draws.y.row(i).mean(), 3 * sd / std::sqrt(1600.)) << i;
        EXPECT_LT(SplitRhat(draws), 1.01) << i;
        EXPECT_GT(BulkEss(draws), 2000) << i;
    }
}

TEST(EmulatedPosterior, WhatTheModelDoesNotExplainWidensIt) {
    // Six summaries that two parameters cannot give: shifted by three deviations in turns.
    const AnalyticSimulator simulator(0, 0);
    EmulationOptions options;
    options.priorRuns = 400;
    options.waves = {{150, 3}, {150, 2}};
    options.maxWaves = 2;
    const Runs prior = RunPrior(simulator, options);
    Vector observed = simulator.Simulate(Eigen::Vector2d(0.4, 5), 9);
    const EmulatedPosterior good = EmulatePosterior(simulator, observed, prior, options);
    for (Eigen::Index i = 0; i < 6; ++i) observed[i] += (i % 2 ? 3 : -3) * simulator.Sd(Vector::Zero(2));
    const EmulatedPosterior odd = EmulatePosterior(simulator, observed, prior, options);
    EXPECT_EQ(good.tau, 1);
    EXPECT_GT(odd.tau, 2);
    const auto sd = [](const EmulatedPosterior& p) {
        return std::sqrt(CovarianceOfColumns(p.draws.y)(1, 1));
    };
    EXPECT_GT(sd(odd), 1.5 * sd(good));
}

/// Of 64 x 64 pixels, as a file of bytes has them.
PhotoSettings SmallPhotograph(double extent) {
    PhotoSettings settings;
    settings.resolution = 64;
    settings.extent = extent;
    settings.isRounded = true;
    return settings;
}

TEST(EmulatedPosteriorLong, FindsBrushedMetalWhoseDarkColumnsHardlyVary) {
    // Some summaries are constant, others scatter by 1e-7 of themselves from seed to seed, and the columns on
    // both sides of the middle are the same number: a covariance of all 124 has no inverse.
    const PhotoSettings settings = SmallPhotograph(6);
    const PhotoSimulator metal(MetalModel(), settings, {});
    EmulationOptions options;
    const Runs prior = RunPrior(metal, options);
    const ParameterSpace& space = metal.Parameters();
    int inside = 0, all = 0;
    for (uint64_t trial = 0; trial < 3; ++trial) {
        Random random(SeedOf("brushed metal"), trial);
        const Vector truth = space.SamplePrior(random), y = space.ToLogit(truth);
        const EmulatedPosterior posterior =
            EmulatePosterior(metal, metal.Simulate(truth, random.Bits()), prior, options);
        EXPECT_EQ(posterior.tau, 1);
        for (Eigen::Index i = 0; i < y.size(); ++i, ++all) {
            const double rank = (posterior.draws.y.row(i).array() < y[i]).cast<double>().mean();
            inside += rank > 0.01 && rank < 0.99;
        }
        // It is known, too, and not only wide: the roughness to a hundredth of its prior.
        const auto roughness = Eigen::Index(*space.Find("roughx"));
        EXPECT_LT(std::sqrt(CovarianceOfColumns(posterior.draws.y)(roughness, roughness)), 0.05);
    }
    // 30 of which .6 are expected outside; as they are correlated, three times a binomial's 2.
    EXPECT_GE(inside, all - 6);
}

TEST(EmulatedPosteriorLong, APhotographOfAnotherMaterialIsFound) {
    const PhotoSettings settings = SmallPhotograph(10);
    const PhotoSimulator bump(BumpModel(), settings, {}), leather(LeatherModel(), settings, {});
    EmulationOptions options;
    const Runs prior = RunPrior(bump, options);
    const auto misfit = [&](const PhotoSimulator& simulator) {
        Random random(SeedOf("another material"));
        const Vector truth = simulator.Parameters().SamplePrior(random);
        return EmulatePosterior(bump, simulator.Simulate(truth, 1), prior, options).waves.back().misfit;
    };
    EXPECT_LT(misfit(bump), options.maxMisfit);
    EXPECT_GT(misfit(leather), options.maxMisfit);
}

TEST(EmulatedPosterior, ThreadsAndInterruptionsDoNotChangeBits) {
    const AnalyticSimulator simulator(0.15, 0.2);
    EmulationOptions options;
    options.priorRuns = 200;
    options.waves = {{100, 3}, {100, 2}};
    options.maxWaves = 2;
    options.walkSteps = 50;
    const Vector observed = simulator.Simulate(Eigen::Vector2d(0.3, 4), 5);
    const std::string path = testing::TempDir() + "lacquer_runs.bin";
    std::filesystem::remove(path);
    std::vector<Matrix> results;
    const auto run = [&](int threads, RunLog* log) {
        const ThreadLimit limit(threads);
        const Runs prior = RunPrior(simulator, options, log);
        results.push_back(EmulatePosterior(simulator, observed, prior, options, log).draws.y);
    };
    for (const int threads : {1, 2, 7}) run(threads, nullptr);
    /// Stops after a number of runs.
    class Stopper final : public Observer {
      public:
        void Advance(int64_t units) override { count_ += units; }
        bool ShouldStop() override { return count_ >= 270; }

      private:
        std::atomic<int64_t> count_ = 0;
    } stopper;
    {
        RunLog log(path, 2, 6);
        const Runs prior = RunPrior(simulator, options, &log, &stopper);
        EXPECT_THROW(EmulatePosterior(simulator, observed, prior, options, &log, &stopper), Interrupted);
    }
    // A record that was torn: half of one more.
    {
        std::ofstream torn(path, std::ios::binary | std::ios::app);
        torn << "twelve bytes";
    }
    RunLog log(path, 2, 6);
    run(2, &log);
    for (size_t i = 1; i < results.size(); ++i) EXPECT_EQ(results[0], results[i]) << i;
    // All 400 runs are in the file now, 100 + 100 of them from the second part.
    RunLog again(path, 2, 6);
    run(1, &again);
    EXPECT_EQ(again.NumRecalled(), 400u);
    EXPECT_EQ(results[0], results.back());
}

TEST(RunLog, FilesThatItCannotGoOnWithAreRefusedWithTheReason) {
    const std::string path = testing::TempDir() + "lacquer_foreign_runs.bin";
    const auto problem = [&](Eigen::Index numParameters) -> std::string {
        try {
            RunLog(path, numParameters, 6);
        } catch (const FileError& error) {
            return error.what();
        }
        return "";
    };
    std::filesystem::remove(path);
    EXPECT_EQ(problem(2), "");
    EXPECT_NE(problem(3).find("2 parameters and 6 summaries, expected 3 and 6"), std::string::npos);
    std::filesystem::resize_file(path, 13);
    EXPECT_NE(problem(2).find("ends after 13 bytes"), std::string::npos) << problem(2);
    std::filesystem::resize_file(path, 5);
    EXPECT_NE(problem(2).find("ends after 5 bytes"), std::string::npos) << problem(2);
    std::filesystem::resize_file(path, 0);
    EXPECT_NE(problem(2).find("is empty"), std::string::npos) << problem(2);
    std::ofstream(path) << "not runs, but text that is long enough";
    EXPECT_NE(problem(2).find("begins with other bytes"), std::string::npos) << problem(2);
    std::filesystem::remove(path);
    std::filesystem::create_directory(path);
    EXPECT_NE(problem(2).find("a folder"), std::string::npos) << problem(2);
    std::filesystem::remove(path);
}

}  // namespace
}  // namespace lacquer::test::emulator_test
