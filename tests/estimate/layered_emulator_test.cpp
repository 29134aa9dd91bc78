// Emulated lobes: what is left of the noise of simulations, and whether intervals that rest on it are right.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "estimate/gradient_check.h"
#include "estimate/layered/lobe_posterior.h"
#include "estimate/layered/next_measurement.h"
#include "estimate/layered/noisy_measurement.h"
#include "support/statistics.h"

namespace lacquer::test::layered_emulator_test {
namespace {

using namespace estimate;

/// A lobe of two widths over a constant, at 16 angles, with simulations of a given relative noise.
class LobeModel final : public Simulator {
  public:
    explicit LobeModel(double noise) : noise_(noise) {
        for (int i = 0; i < 2 * kAngles; ++i) names_.push_back(fmt::format("value {}", i));
    }
    static constexpr int kAngles = 16;
    const ParameterSpace& Parameters() const override { return space_; }
    const std::vector<std::string>& SummaryNames() const override { return names_; }
    Vector Values(const Vector& x) const {
        Vector f(kAngles);
        for (int i = 0; i < kAngles; ++i) {
            const double angle = 0.1 * i;
            f[i] = 0.05 + std::exp(-angle * angle / (2 * x[0] * x[0])) / x[0] +
                   std::exp(-2 * x[1]) * std::exp(-angle * angle);
        }
        return f;
    }
    Vector Measure(const Vector& x, uint64_t seed, double noise) const {
        const Vector f = Values(x);
        Random random(seed);
        Vector all(2 * kAngles);
        all << f.cwiseProduct((1 + noise * random.Normals(kAngles).array()).max(0.01).matrix()), noise * f;
        return all;
    }
    Vector Simulate(const Vector& x, uint64_t seed) const override { return Measure(x, seed, noise_); }

  private:
    double noise_;
    ParameterSpace space_{{{"width", "", {0.4, 20, 0.1, 0.8}}, {"depth", "", {1, 50, 0.05, 2}}}};
    std::vector<std::string> names_;
};

/// A model with all that a posterior of it needs.
struct LobeProblem {
    explicit LobeProblem(double simulationNoise) : model(simulationNoise) {
        options.numWalks = 50;
        options.walkSteps = 120;
        options.waveRuns = 40;
        options.maxWaves = 4;
    }
    LobeModel model;
    ParameterSpace space = WithNoise(model.Parameters());
    LobeCoordinates coordinates{model.Parameters(), 2};
    LobeOptions options;
};

TEST(LobeEmulator, AveragesTheNoiseOfSimulationsAndKnowsWhatIsLeft) {
    constexpr double kNoise = 0.1;
    const LobeProblem problem(kNoise);
    const Runs runs = RunLobePrior(problem.model, problem.options);
    const LobeRuns logs = LogsOf(runs, 1e-6);
    Matrix points(2, runs.Count());
    for (Eigen::Index i = 0; i < runs.Count(); ++i)
        points.col(i) =
            problem.coordinates.FromNatural(problem.model.Parameters().ToNatural(runs.parameters.col(i)));
    const LobeEmulator emulator(points, logs.values, logs.errors);
    Random random(SeedOf("emulator"));
    double squares = 0, predicted = 0;
    constexpr int kPlaces = 200;
    for (int i = 0; i < kPlaces; ++i) {
        const Vector x = problem.model.Parameters().SamplePrior(random),
                     point = problem.coordinates.FromNatural(x);
        squares +=
            (emulator.Predict(point) - FlooredLogs(problem.model.Values(x), 1e-6)).squaredNorm() / kPlaces;
        predicted +=
            (emulator.Components() * emulator.Variances(point).cwiseSqrt().asDiagonal()).squaredNorm() /
                kPlaces +
            emulator.Remainder().sum() / kPlaces;
    }
    // A single simulation errs by 0.1; 180 of them together by less than a half of that.
    EXPECT_LT(std::sqrt(squares / LobeModel::kAngles), 0.5 * kNoise);
    EXPECT_GT(predicted / squares, 0.5) << predicted / squares;
    EXPECT_LT(predicted / squares, 2);
}

TEST(LobeEmulator, DerivativesAreThoseOfItsValues) {
    const LobeProblem problem(0.05);
    const Runs runs = RunLobePrior(problem.model, problem.options);
    const LobeRuns logs = LogsOf(runs, 1e-3);
    Matrix points(2, runs.Count());
    for (Eigen::Index i = 0; i < runs.Count(); ++i)
        points.col(i) = problem.model.Parameters().ToNatural(runs.parameters.col(i));
    const LobeEmulator emulator(points, logs.values, logs.errors);
    const Vector at{{0.33, 0.8}};
    Matrix derivatives;
    emulator.Coefficients(at, &derivatives);
    constexpr double kStep = 1e-5;
    for (Eigen::Index i = 0; i < 2; ++i) {
        Vector above = at, below = at;
        above[i] += kStep;
        below[i] -= kStep;
        const Vector difference =
            (emulator.Coefficients(above, nullptr) - emulator.Coefficients(below, nullptr)) / (2 * kStep);
        EXPECT_LT((difference - derivatives.col(i)).norm(), 1e-6 * derivatives.col(i).norm());
    }
}

TEST(LobeLikelihood, IsThatOfADenseCovarianceWithItsDerivatives) {
    constexpr Eigen::Index kCount = 9;
    Random random(SeedOf("likelihood"));
    const Vector observed = random.Normals(kCount), mean = random.Normals(kCount),
                 sds = 0.1 * random.Normals(kCount).cwiseAbs();
    Matrix common(kCount, 2);
    for (double& value : common.reshaped()) value = 0.3 * random.Normal();
    const Vector own = 0.05 * random.Normals(kCount).cwiseAbs();
    const double noise = 0.2;
    for (const bool isRobust : {false, true}) {
        const LobeLikelihood likelihood(observed, sds, {own, common}, isRobust);
        Vector byMean;
        double byNoise = 0;
        const double value = likelihood.Log(mean, noise, &byMean, &byNoise);
        if (!isRobust) {
            Matrix covariance = common * common.transpose();
            covariance.diagonal() += (own.array() + sds.array().square() + noise * noise).matrix();
            const Eigen::LLT<Matrix> factor(covariance);
            const Vector r = observed - mean;
            const double expected =
                -0.5 * r.dot(factor.solve(r)) - Matrix(factor.matrixL()).diagonal().array().log().sum();
            EXPECT_NEAR(value, expected, 1e-10 * std::abs(expected));
        }
        constexpr double kStep = 1e-6;
        for (Eigen::Index i = 0; i < kCount; ++i) {
            Vector above = mean, below = mean;
            above[i] += kStep;
            below[i] -= kStep;
            const double slope = (likelihood.Log(above, noise, nullptr, nullptr) -
                                  likelihood.Log(below, noise, nullptr, nullptr)) /
                                 (2 * kStep);
            EXPECT_NEAR(byMean[i], slope, 1e-6 * (1 + std::abs(slope)));
        }
        const double slope = (likelihood.Log(mean, noise + kStep, nullptr, nullptr) -
                              likelihood.Log(mean, noise - kStep, nullptr, nullptr)) /
                             (2 * kStep);
        EXPECT_NEAR(byNoise, slope, 1e-6 * (1 + std::abs(slope)));
    }
}

TEST(LobeTarget, GradientsAreDifferencesInsideAndOutsideOfTheSimulations) {
    const LobeProblem problem(0.05);
    const Runs runs = RunLobePrior(problem.model, problem.options);
    const ObservedLobes observed =
        ObserveLobes(problem.model.Values(Vector{{0.3, 0.7}}), Vector::Zero(LobeModel::kAngles));
    const LobePosterior posterior =
        FindLobePosterior(problem.model, problem.space, problem.coordinates, observed, runs, problem.options);
    const Vector center = posterior.draws.y.rowwise().mean();
    for (const double away : {0., 0.5, 8.}) {
        const Vector y = center + away * Vector{{0.1, -0.2, 0.1}};
        Vector gradient;
        posterior.target->LogDensity(y, &gradient);
        for (Eigen::Index i = 0; i < y.size(); ++i) {
            constexpr double kStep = 1e-5;
            Vector above = y, below = y;
            above[i] += kStep;
            below[i] -= kStep;
            const double slope = (posterior.target->LogDensity(above, nullptr) -
                                  posterior.target->LogDensity(below, nullptr)) /
                                 (2 * kStep);
            EXPECT_NEAR(gradient[i], slope, 1e-4 * (1 + gradient.norm())) << away << ' ' << i;
        }
    }
}

/// Calibration of the method.
/// @param errorScale   what the method takes the emulator's error for
/// @param hiddenNoise  by which factor measurements are noisier than the method is told
CalibrationReport CalibrateLobes(double simulationNoise, double errorScale, double hiddenNoise) {
    LobeProblem problem(simulationNoise);
    problem.options.errorScale = errorScale;
    problem.options.maxWaves = 2;
    // The noise is all but known: a method that finds it would find what is hidden from it.
    problem.space = WithNoise(problem.model.Parameters(), {0.02, 1e-4, 0.019, 0.021});
    const NoisyMeasurement measurements(
        problem.space, problem.model.SummaryNames(),
        [&](const Vector& x, uint64_t seed) {
            Vector all = problem.model.Measure(x, seed, 1e-3);
            all.head(LobeModel::kAngles).array() *= (std::sqrt(hiddenNoise * hiddenNoise - 1) * 0.02 *
                                                     Random(seed, 5).Normals(LobeModel::kAngles).array())
                                                        .exp();
            return all;
        },
        1e-4);
    problem.options.seed = SeedOf("calibrated lobes");
    const Runs prior = RunLobePrior(problem.model, problem.options);
    return Calibrate(measurements,
                     [&](const Vector& summaries, uint64_t seed) {
                         LobeOptions options = problem.options;
                         options.seed = seed;
                         return FindLobePosterior(problem.model, problem.space, problem.coordinates,
                                                  measurements.Observed(summaries), prior, options)
                             .draws.y;
                     },
                     {.replicates = 100, .seed = SeedOf("replicates of lobes")});
}
bool PassesForTheModel(const CalibrationReport& report) {
    return report.parameters[0].Passes() && report.parameters[1].Passes();
}

// With 100 replicates, 90 % intervals hold 90 +- 3 of them: 80 is 3.3 sigma.
TEST(LobePosteriorLong, IsCalibratedThoughEachSimulationIsAsNoisyAsTheMeasurement) {
    const CalibrationReport report = CalibrateLobes(0.03, 1, 1);
    EXPECT_TRUE(PassesForTheModel(report)) << report.ToString();
    for (int i = 0; i < 2; ++i) EXPECT_GT(report.parameters[size_t(i)].coverage90, 0.8) << report.ToString();
}
TEST(LobePosteriorLong, NegativeControlWithoutTheErrorOfSimulationsIntervalsAreTooNarrow) {
    const CalibrationReport report = CalibrateLobes(0.25, 0, 1);
    EXPECT_FALSE(PassesForTheModel(report)) << report.ToString();
}
TEST(LobePosteriorLong, NegativeControlWithNoiseTakenForTooSmallIntervalsAreTooNarrow) {
    EXPECT_FALSE(PassesForTheModel(CalibrateLobes(0.02, 1, 1 / 0.4)));
}

TEST(NextMeasurement, IsWherePredictionsDifferMostAndSimulationsAreNotToBlame) {
    const std::vector<DirectionAngles> directions = {{0, 0, 10, 0}, {0, 0, 20, 0}, {0, 0, 30, 0}};
    Random random(SeedOf("next"));
    Matrix draws(2, 400), predicted(400, 3);
    for (Eigen::Index i = 0; i < 400; ++i) {
        draws.col(i) = random.Normals(2);
        // The last one differs most, all of it by noise of its simulations.
        predicted.row(i) << 0.02 * draws(0, i), 0.06 * draws(0, i) - 0.08 * draws(1, i),
            0.3 * random.Normal();
    }
    const std::vector<NextDirection> ranked = RankDirections(directions, draws, predicted, 0.05);
    EXPECT_EQ(ranked[0].direction.thetaO, 20);
    EXPECT_NEAR(ranked[0].ratio, 4, 1);  // 400 draws: 7 %, 4 sigma is 1.1
    EXPECT_NEAR(ranked[0].deviation, 0.1, 0.015);
}

}  // namespace
}  // namespace lacquer::test::layered_emulator_test
