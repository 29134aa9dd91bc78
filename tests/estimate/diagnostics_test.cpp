#include <gtest/gtest.h>

#include <cmath>

#include "estimate/diagnostics/convergence.h"
#include "estimate/diagnostics/pareto_smoothing.h"
#include "estimate/random.h"
#include "support/statistics.h"

namespace lacquer::test::diagnostics_test {
namespace {

using namespace estimate;

/// Chains of x' = rho x + sqrt(1 - rho^2) xi: standard normal, with autocorrelation rho^lag.
Matrix AutoregressiveChains(const std::string& name, double rho, Eigen::Index draws, Eigen::Index chains) {
    Random random(SeedOf(name));
    Matrix x(draws, chains);
    for (Eigen::Index c = 0; c < chains; ++c) {
        double state = random.Normal();
        for (Eigen::Index i = 0; i < draws; ++i) {
            x(i, c) = state;
            state = rho * state + std::sqrt(1 - rho * rho) * random.Normal();
        }
    }
    return x;
}

TEST(Convergence, EffectiveSizesOfAutoregressiveChainsAreTheClosedForm) {
    // N (1 - rho) / (1 + rho). The estimate's own error is near 2 sqrt(tau / N), tau the integrated time: 3 %
    // at .9 and 80,000 draws; leaving out the lags beyond 10 would miss half of it.
    for (const double rho : {-0.5, 0., 0.5, 0.9}) {
        const Matrix x = AutoregressiveChains("autoregressive", rho, 20000, 4);
        const double expected = double(x.size()) * (1 - rho) / (1 + rho);
        EXPECT_NEAR(MeanEss(x) / expected, 1, 0.1) << rho;
        EXPECT_NEAR(BulkEss(x) / expected, 1, 0.1) << rho;
        EXPECT_LT(SplitRhat(x), 1.005) << rho;
    }
}

TEST(Convergence, TailsThatAreExploredSlowlyShowInTheTailSize) {
    // Signs are independent, magnitudes stay for long: the mean is known well, the quantiles are not.
    const Matrix slow = AutoregressiveChains("magnitudes", 0.99, 4000, 4);
    Random random(SeedOf("signs"));
    Matrix x = slow.cwiseAbs();
    for (double& value : x.reshaped()) value *= random.Uniform() < 0.5 ? -1 : 1;
    EXPECT_GT(BulkEss(x), 8000);
    EXPECT_LT(TailEss(x), 0.25 * BulkEss(x));
}

TEST(Convergence, RhatSeesShiftsAndScalesAndDrifts) {
    const Matrix good = AutoregressiveChains("good", 0, 1000, 4);
    EXPECT_LT(SplitRhat(good), 1.01);
    Matrix shifted = good, scaled = good, drifting = good;
    shifted.col(0).array() += 0.5;
    scaled.col(0) *= 2;  // the means agree: only distances from the median tell
    for (Eigen::Index i = 0; i < 1000; ++i) drifting.row(i).array() += double(i) / 1000;
    EXPECT_GT(SplitRhat(scaled), 1.01);
    EXPECT_GT(SplitRhat(drifting), 1.01);  // without splitting, all four agree
    // The means of eight halves, of which two are shifted by delta, have the variance 3 / 14 delta^2; that of
    // 500 draws, .045 each, changes R-hat by .005.
    EXPECT_NEAR(SplitRhat(shifted), std::sqrt(1 + 3. / 14 * 0.25), 0.015);
}

TEST(Convergence, RhatDoesNotNeedMoments) {
    Matrix x = AutoregressiveChains("cauchy", 0, 1000, 4);
    for (double& value : x.reshaped()) value = std::tan(3.14159265 * (NormalCdf(value) - 0.5));
    EXPECT_LT(SplitRhat(x), 1.01);
    EXPECT_GT(BulkEss(x), 3000);
}

TEST(Convergence, WhatCannotBeJudgedIsNaN) {
    EXPECT_TRUE(std::isnan(SplitRhat(Matrix::Constant(100, 4, 1.5))));
    EXPECT_TRUE(std::isnan(BulkEss(Matrix::Zero(3, 4))));
    Matrix broken = AutoregressiveChains("broken", 0, 100, 2);
    broken(5, 1) = std::nan("");
    EXPECT_TRUE(std::isnan(ConvergenceOf(broken).tailEss));
    EXPECT_TRUE(std::isnan(EBfmi({1})));
}

TEST(Convergence, EnergiesOfIndependentAndSlowChains) {
    // E[(a - b)^2] / var = 2 (1 - rho).
    for (const double rho : {0., 0.9}) {
        const Matrix x = AutoregressiveChains("energies", rho, 40000, 1);
        EXPECT_NEAR(EBfmi({x.data(), x.data() + x.size()}), 2 * (1 - rho), 0.04) << rho;
    }
}

TEST(ParetoSmoothing, ShapesOfParetoWeightsAreFound) {
    // w = u^-k has a Pareto tail of shape k. 40,000 weights have a tail of 600, whose k is known to
    // (1 + k) / sqrt(600) = .04 to .08: three of these, and the prior's pull of 10 / 610 towards 1/2.
    for (const double k : {0.2, 0.5, 1.}) {
        Random random(SeedOf("pareto"));
        std::vector<double> logWeights(40000);
        for (double& w : logWeights) w = -k * std::log(random.Uniform());
        EXPECT_NEAR(ParetoSmooth(logWeights).k, k, 3 * (1 + k) / std::sqrt(600.) + 0.01) << k;
    }
}

TEST(ParetoSmoothing, WeightsOfANarrowProposalAreDistrusted) {
    // Target N(0, 1), proposal N(0, s^2): w = exp(-x^2 (1 - 1/s^2) / 2) has shape 1 - s^2 for s < 1.
    const auto weightsFor = [](double s) {
        Random random(SeedOf("proposal"));
        std::vector<double> logWeights(4000);
        for (double& w : logWeights) {
            const double x = s * random.Normal();
            w = -0.5 * x * x * (1 - 1 / (s * s));
        }
        return ParetoSmooth(logWeights);
    };
    EXPECT_LT(weightsFor(1.3).k, 0.3);
    EXPECT_GT(weightsFor(0.4).k, 0.6);
    const SmoothedWeights good = weightsFor(1.3);
    double sum = 0;
    for (const double w : good.weights) sum += w;
    EXPECT_NEAR(sum, 1, 1e-12);
    EXPECT_TRUE(std::isinf(ParetoSmooth({0, 0, 0}).k));
    EXPECT_TRUE(std::isinf(ParetoSmooth({}).k));
}

}  // namespace
}  // namespace lacquer::test::diagnostics_test
