#include "estimate/parameters.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "support/statistics.h"

namespace lacquer::test::parameters_test {
namespace {

using namespace estimate;

ParameterSpace ThreeParameters() {
    return ParameterSpace({{"light", "", {999, 500, 0, 2500}},
                           {"rough", "", {0.2, 0.2, 0.1, 0.8}},
                           {"tail", "cm", {0, 1, 6, 9}}});  // all of it six deviations above its mean
}

TEST(NormalDistribution, QuantilesInvertTheDistributionFunction) {
    for (double z = -37; z < 8; z += 0.0625) {
        const double p = NormalCdf(z);
        // dz = dp / density: where p is near 1, its last digit is worth this much of z.
        const double digit = 1.2e-16 / (std::exp(-0.5 * z * z) / std::sqrt(2 * 3.14159265358979));
        EXPECT_NEAR(NormalQuantile(p), z, 4e-14 + (z > 0 ? 2 * digit : 0)) << z;
    }
    EXPECT_DOUBLE_EQ(NormalQuantile(0.5), 0);
    EXPECT_DOUBLE_EQ(NormalQuantile(0.975), 1.959963984540054);
}

TEST(NormalDistribution, CutDensitiesIntegrateToOne) {
    for (const TruncatedNormal& d : {TruncatedNormal{0, 1, -1, 2}, TruncatedNormal{0, 1, 6, 9},
                                     TruncatedNormal{5, 0.1, 2, 4}, TruncatedNormal{0, 10, 0, 1}}) {
        // Simpson's rule, whose step must be below the length over which the density decays.
        const double slope = std::max(std::abs(d.low - d.mean), std::abs(d.high - d.mean)) / (d.sd * d.sd);
        const double step = (d.high - d.low) / 4096;
        ASSERT_LT(step * slope, 0.2);
        double sum = 0;
        for (int i = 0; i <= 4096; ++i)
            sum += std::exp(d.LogDensity(d.low + i * step)) * (i == 0 || i == 4096 ? 1 : i % 2 ? 4 : 2);
        EXPECT_NEAR(sum * step / 3, 1, 1e-7) << d.low;
        EXPECT_EQ(d.LogDensity(d.high + 1e-9), -std::numeric_limits<double>::infinity());
    }
}

TEST(ParameterSpace, LogitsAndNaturalUnitsAreInverse) {
    const ParameterSpace space = ThreeParameters();
    Random random(SeedOf("logits"));
    for (int i = 0; i < 100; ++i) {
        const Vector x = space.SamplePrior(random), back = space.ToNatural(space.ToLogit(x));
        for (Eigen::Index k = 0; k < 3; ++k) EXPECT_NEAR(back[k], x[k], 1e-12 * 2500) << k;
    }
    // Bounds themselves are moved inside, so that they are finite.
    const Vector y = space.ToLogit(Eigen::Vector3d(0, 0.8, 9));
    EXPECT_NEAR(y[0], std::log(1e-6), 1e-5);
    EXPECT_NEAR(y[1], -std::log(1e-6), 1e-5);
    EXPECT_TRUE(space.ToNatural(Vector::Constant(3, 800)).allFinite());
    EXPECT_TRUE(std::isfinite(space.LogPriorOfLogit(Vector::Constant(3, -800))));
}

TEST(ParameterSpace, GradientsOfThePriorAreItsDifferences) {
    const ParameterSpace space = ThreeParameters();
    Random random(SeedOf("gradients"));
    for (int i = 0; i < 20; ++i) {
        const Vector y = 2 * random.Normals(3), x = space.ToNatural(y);
        Vector inLogit, inNatural;
        space.LogPriorOfLogit(y, &inLogit);
        space.LogPrior(x, &inNatural);
        for (Eigen::Index k = 0; k < 3; ++k) {
            const double h = 1e-5, hx = 1e-5 * space[size_t(k)].prior.sd;
            Vector e = Vector::Zero(3);
            e[k] = 1;
            EXPECT_NEAR((space.LogPriorOfLogit(y + h * e) - space.LogPriorOfLogit(y - h * e)) / (2 * h),
                        inLogit[k], 1e-6);
            EXPECT_NEAR((space.LogPrior(x + hx * e) - space.LogPrior(x - hx * e)) / (2e-5),
                        inNatural[k] * space[size_t(k)].prior.sd, 1e-6);
            EXPECT_NEAR((space.ToNatural(y + h * e) - space.ToNatural(y - h * e))[k] / (2 * h),
                        space.Slopes(y)[k], 1e-6 * space.Slopes(y)[k] + 1e-7);
        }
    }
}

/// Kolmogorov's distance of draws, as parts of the prior below them, from uniform numbers.
double DistanceFromUniform(std::vector<double> u) {
    std::sort(u.begin(), u.end());
    double most = 0;
    for (size_t i = 0; i < u.size(); ++i)
        most = std::max({most, double(i + 1) / double(u.size()) - u[i], u[i] - double(i) / double(u.size())});
    return most;
}

TEST(ParameterSpace, DrawsFollowTheCutPrior) {
    // 4000 draws: a distance of 1.95 / sqrt(4000) = .031 has a probability of 1e-3. Moving draws outside of
    // the bounds to the bounds instead, as is sometimes done, puts 31 % of "rough" onto its lower end.
    const ParameterSpace space = ThreeParameters();
    constexpr int kDraws = 4000;
    Random random(SeedOf("draws of the prior"));
    std::vector<double> below[3], clamped;
    for (int i = 0; i < kDraws; ++i) {
        const Vector x = space.SamplePrior(random);
        for (size_t k = 0; k < 3; ++k) {
            const Prior& d = space[k].prior;
            const TruncatedNormal part{d.mean, d.sd, d.low, std::max(x[Eigen::Index(k)], d.low + 1e-9)};
            below[k].push_back(part.Mass() / d.Mass());
        }
        const Prior& d = space[1].prior;
        const double moved = std::clamp(d.mean + d.sd * random.Normal(), d.low + 1e-9, d.high);
        clamped.push_back(TruncatedNormal{d.mean, d.sd, d.low, moved}.Mass() / d.Mass());
    }
    for (const auto& u : below) EXPECT_LT(DistanceFromUniform(u), 1.95 / std::sqrt(kDraws));
    EXPECT_GT(DistanceFromUniform(clamped), 0.2);
}

TEST(ParameterSpace, BadPriorsAreNamed) {
    const auto messageOf = [](const Prior& prior) -> std::string {
        try {
            ParameterSpace({{"rough", "", prior}});
        } catch (const std::invalid_argument& error) {
            return error.what();
        }
        return "";
    };
    EXPECT_EQ(messageOf({0, 1, 0, 1}), "");
    EXPECT_EQ(messageOf({0, 0, 0, 1}), "parameter \"rough\": the prior's deviation is 0, must be positive");
    EXPECT_EQ(messageOf({0, 1, 1, 1}), "parameter \"rough\": the lower bound 1 is not below the upper one 1");
    EXPECT_EQ(messageOf({0, 1, 50, 60}), "parameter \"rough\": the prior has no mass between 50 and 60");
    EXPECT_NE(messageOf({std::nan(""), 1, 0, 1}).find("finite"), std::string::npos);
    EXPECT_THROW(ParameterSpace({{"a", "", {0, 1, 0, 1}}, {"a", "", {0, 1, 0, 1}}}), std::invalid_argument);
}

}  // namespace
}  // namespace lacquer::test::parameters_test
