#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "estimate/analytic_simulator.h"
#include "estimate/covariance/fixed_seed.h"
#include "estimate/mode/find_modes.h"
#include "pbrt/core/parallel.h"
#include "support/statistics.h"

namespace lacquer::test::modes_test {
namespace {

using namespace estimate;

/// The analytic simulator with gradients, by differences.
class WithGradient final : public Simulator {
  public:
    explicit WithGradient(const Simulator& simulator) : simulator_(simulator) {}
    const ParameterSpace& Parameters() const override { return simulator_.Parameters(); }
    const std::vector<std::string>& SummaryNames() const override { return simulator_.SummaryNames(); }
    Vector Simulate(const Vector& x, uint64_t seed) const override { return simulator_.Simulate(x, seed); }
    std::unique_ptr<DifferentiableRun> SimulateForGradient(const Vector& x, uint64_t seed) const override {
        class Run final : public DifferentiableRun {
          public:
            Run(const Simulator& simulator, const Vector& x, uint64_t seed)
                : summaries_(simulator.Simulate(x, seed)), jacobian_(summaries_.size(), x.size()) {
                for (Eigen::Index i = 0; i < x.size(); ++i) {
                    const double h = 1e-6 * simulator.Parameters()[size_t(i)].prior.sd;
                    Vector high = x, low = x;
                    high[i] += h;
                    low[i] -= h;
                    jacobian_.col(i) =
                        (simulator.Simulate(high, seed) - simulator.Simulate(low, seed)) / (2 * h);
                }
            }
            const Vector& Summaries() const override { return summaries_; }
            Vector Gradient(const Vector& adjoint) const override { return jacobian_.transpose() * adjoint; }

          private:
            Vector summaries_;
            Matrix jacobian_;
        };
        return std::make_unique<Run>(simulator_, x, seed);
    }

  private:
    const Simulator& simulator_;
};

struct Case {
    AnalyticSimulator simulator{0.15, 0.1};
    Vector truth = Eigen::Vector2d(0.55, 4.2);
    Vector observed = simulator.Simulate(truth, SeedOf("photograph"));
    SummaryScatter scatter = MeasureScatter(simulator, truth, 200, SeedOf("scatter"));
};

TEST(FixedSeedTarget, GradientsAreDifferencesOfDensityAndEnergy) {
    const Case c;
    const WithGradient simulator(c.simulator);
    for (const CovarianceError error : {CovarianceError::Hartlap, CovarianceError::Student}) {
        const FixedSeedTarget target(simulator, c.observed, c.scatter, {.covarianceError = error});
        ASSERT_TRUE(target.HasGradient());
        const Vector y = c.simulator.Parameters().ToLogit(c.truth);
        Vector ofDensity, ofEnergy;
        target.LogDensity(y, &ofDensity);
        target.Energy(y, &ofEnergy);
        for (Eigen::Index i = 0; i < 2; ++i) {
            Vector high = y, low = y;
            high[i] += 1e-5;
            low[i] -= 1e-5;
            EXPECT_NEAR((target.LogDensity(high, nullptr) - target.LogDensity(low, nullptr)) / 2e-5,
                        ofDensity[i], 1e-5 * (1 + std::abs(ofDensity[i])));
            EXPECT_NEAR((target.Energy(high, nullptr) - target.Energy(low, nullptr)) / 2e-5, ofEnergy[i],
                        1e-5 * (1 + std::abs(ofEnergy[i])));
        }
    }
}

TEST(FixedSeedTarget, TheCovarianceCountsTheScatterOfTheOwnSeeds) {
    // Misfits at the truth, over photographs and seeds, have the mean of a chi-square variable of six
    // summaries times Hartlap's bias (200 runs: 199 / 192 - 1 = 4 %). Without the factor 1 + 1/K it is twice
    // that for K = 1.
    Case c;
    for (const bool countsOwnScatter : {true, false}) {
        RunningMean misfits;
        for (uint64_t i = 0; i < 400; ++i) {
            const Vector observed = c.simulator.Simulate(c.truth, Hash(SeedOf("photographs"), i));
            const FixedSeedTarget target(
                c.simulator, observed, c.scatter,
                {.seeds = {Hash(SeedOf("own seeds"), i)}, .countsOwnScatter = countsOwnScatter});
            misfits.Add(target.Misfit(c.simulator.Parameters().ToLogit(c.truth)));
        }
        const double expected = countsOwnScatter ? 6 : 12;
        EXPECT_NEAR(misfits.Mean() / expected, 1.04, 4 * misfits.StandardError() / expected + 0.06);
    }
}

TEST(FixedSeedTarget, AnErrorByHandCountsTheMeanOfSquares) {
    const Case c;
    constexpr double kError = 0.3;
    const uint64_t seed = SeedOf("own seed");
    const FixedSeedTarget target(c.simulator, c.observed, ScatterByHand(6, kError),
                                 {.seeds = {seed}, .countsOwnScatter = false});
    const double mean = (c.simulator.Simulate(c.truth, seed) - c.observed).squaredNorm() / 6;
    const Vector y = c.simulator.Parameters().ToLogit(c.truth);
    EXPECT_NEAR(target.Misfit(y), mean / (kError * kError), 1e-6 * mean / (kError * kError));
    EXPECT_NEAR(target.LogDensity(y, nullptr) - c.simulator.Parameters().LogPriorOfLogit(y),
                -0.5 * mean / (kError * kError), 1e-6);
}

TEST(FindModes, CovariancesAreThoseOfTheCurvature) {
    const ThreadLimit limit(1);
    const Case c;
    const FixedSeedTarget target(c.simulator, c.observed, c.scatter, {});
    const Vector y = FindModes(target, {.seed = SeedOf("modes")})[0].y;
    const Matrix covariance = CovarianceAt(target, y);
    constexpr double kStep = 0.05;
    for (Eigen::Index i = 0; i < 2; ++i) {
        const Vector step = kStep * Vector::Unit(2, i);
        const double curvature = (target.Energy(y + step, nullptr) + target.Energy(y - step, nullptr) -
                                  2 * target.Energy(y, nullptr)) /
                                 (kStep * kStep);
        // Second derivatives of the residuals are left out of one of them.
        EXPECT_NEAR(covariance.inverse()(i, i), curvature, 0.25 * curvature);
    }
}

TEST(FindModes, AgreeWithASearchOnAGridWithGradientsAndWithout) {
    const ThreadLimit limit(1);  // runs of microseconds
    const Case c;
    const WithGradient simulator(c.simulator);
    const FixedSeedTarget smooth(simulator, c.observed, c.scatter, {}),
        plain(c.simulator, c.observed, c.scatter, {});
    double least = std::numeric_limits<double>::infinity();
    Vector best;
    for (double a = -3; a <= 3; a += 0.05)
        for (double b = -3; b <= 3; b += 0.05) {
            const double energy = plain.Energy(Eigen::Vector2d(a, b), nullptr);
            if (energy < least) {
                least = energy;
                best = Eigen::Vector2d(a, b);
            }
        }
    EXPECT_FALSE(plain.HasGradient());
    for (const FixedSeedTarget* target : {&smooth, &plain}) {
        const std::vector<Mode> modes = FindModes(*target, {.seed = SeedOf("modes")});
        ASSERT_FALSE(modes.empty());
        EXPECT_LE(modes[0].energy, least + 1e-6);
        EXPECT_LT((modes[0].y - best).norm(), 0.07);
        EXPECT_GT(modes[0].misfit, 0);
    }
}

TEST(FindModes, ThreadsDoNotChangeBits) {
    const Case c;
    const FixedSeedTarget target(c.simulator, c.observed, c.scatter, {});
    std::vector<Vector> found;
    for (const int threads : {1, 2, 7}) {
        const ThreadLimit limit(threads);
        found.push_back(
            FindModes(target, {.seed = 3, .numDraws = 8, .numStarts = 1, .maxIterations = 4})[0].y);
    }
    EXPECT_EQ(found[0], found[1]);
    EXPECT_EQ(found[0], found[2]);
}

/// Residuals of which two minima are equal: the sign of a parameter cannot be known.
class EvenSimulator final : public Simulator {
  public:
    const ParameterSpace& Parameters() const override { return space_; }
    const std::vector<std::string>& SummaryNames() const override { return names_; }
    Vector Simulate(const Vector& x, uint64_t seed) const override {
        return Vector::Constant(1, x[0] * x[0] + 0.01 * Random(seed).Normal());
    }

  private:
    ParameterSpace space_{{{"offset", "cm", {0, 1, -2, 2}}}};
    std::vector<std::string> names_{"square"};
};

TEST(FindModes, EqualMinimaAreAllReported) {
    const ThreadLimit limit(1);
    const EvenSimulator simulator;
    const SummaryScatter scatter = MeasureScatter(simulator, Vector::Constant(1, 1.), 100, 1);
    const FixedSeedTarget target(simulator, Vector::Constant(1, 0.81), scatter, {});
    const std::vector<Mode> modes = FindModes(target, {.seed = 5, .numStarts = 8});
    ASSERT_EQ(modes.size(), 2u);
    const auto at = [&](size_t i) { return simulator.Parameters().ToNatural(modes[i].y)[0]; };
    EXPECT_NEAR(at(0) * at(1), -0.81, 0.02);
}

}  // namespace
}  // namespace lacquer::test::modes_test
