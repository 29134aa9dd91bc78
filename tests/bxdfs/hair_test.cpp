#include "pbrt/bxdfs/hair.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pbrt/core/sampling.h"
#include "pbrt/scattering/bessel.h"
#include "pbrt/scattering/fresnel.h"
#include "support/lanes.h"
#include "support/statistics.h"

namespace lacquer::hair_test {
namespace {

using test::FullTestName;
using test::Lanes;
using test::Outcome;
using test::Passes;
using test::RunningMean;
using test::SeedOf;
using test::ZTest;

/// A direction by its inclination to the normal plane and its azimuth in that plane.
Vec3 Direction(float theta, float phi) {
    return {std::sin(theta), std::cos(theta) * std::cos(phi), std::cos(theta) * std::sin(phi)};
}
/// What the fibre scatters, without the cosine of the surface that stands for it.
SampledSpectrum Scattered(const HairBxDF& hair, Vec3 wo, Vec3 wi) {
    return hair.Evaluate(wo, wi, {}).f * AbsCosTheta(wi);
}

TEST(BesselI0Scaled, AgreesWithTheStandardLibrary) {
    for (double x = 0; x < 600; x = x * 1.05 + 0.01) {
        const double expected = std::cyl_bessel_i(0, x) * std::exp(-x);
        EXPECT_NEAR(double(BesselI0Scaled(float(x))), expected, 1e-6 * expected) << x;
    }
    EXPECT_NEAR(double(BesselI0Scaled(1e8f)) * std::sqrt(2 * 3.14159265358979 * 1e8), 1, 1e-6);
    EXPECT_EQ(BesselI0Scaled(0), 1);
}

/// Mean over wo, wi and the offset across the fibre of what uniform light of radiance 1 makes of the fibre.
Outcome Furnace(const HairBxDF::Parameters& parameters, double expected, uint64_t seed) {
    Rng rng(seed);
    RunningMean mean;
    for (int i = 0; i < 30000; ++i) {
        HairBxDF::Parameters p = parameters;
        p.h = 2 * rng.Uniform() - 1;
        const HairBxDF hair(p);
        const Vec3 wo = SampleUniformSphere(rng.Uniform2D()), wi = SampleUniformSphere(rng.Uniform2D());
        mean.Add(double(Scattered(hair, wo, wi).Average()) * 4 * 3.14159265358979);
    }
    return ZTest(mean, expected, 1e-4, "furnace");
}

// Power: the values of uniform directions have a variance of 1 to 12 here; the standard error is 0.006 to
// 0.02, and a loss of 0.1 is seen at 5 of them. The lossless rows of the conformance suite see 1e-4.
TEST(Hair, WhiteFurnaceLosesNothing) {
    for (const float beta_m : {0.2f, 0.5f, 1.f})
        for (const float beta_n : {0.3f, 1.f})
            EXPECT_TRUE(Passes(
                FullTestName() + std::to_string(beta_m) + std::to_string(beta_n), 1e-5, [&](uint64_t seed) {
                    return Furnace(
                        {.sigma_a = SampledSpectrum(0), .beta_m = beta_m, .beta_n = beta_n, .alpha = 0.03f},
                        1, seed);
                }));
}

TEST(Hair, NegativeControlTheFurnaceSeesALossOfATenth) {
    const HairBxDF::Parameters p{.sigma_a = SampledSpectrum(0), .beta_m = 0.5f, .beta_n = 1};
    EXPECT_LT(Furnace(p, 0.9, SeedOf(FullTestName())).pValue, 1e-5);
}

// Without scales, exchanging the directions and looking from the other side of the fibre gives the same,
// where the inclinations agree: elsewhere the model takes attenuations at wo alone.
TEST(Hair, IsReciprocalAtEqualInclinations) {
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 500; ++i) {
        HairBxDF::Parameters p{.h = 2 * rng.Uniform() - 1, .sigma_a = SampledSpectrum(0.5f)};
        const float theta = 1.4f * (2 * rng.Uniform() - 1), sign = rng.Uniform() < 0.5f ? -1.f : 1.f;
        const Vec3 wo = Direction(theta, 6 * rng.Uniform()), wi = Direction(sign * theta, 6 * rng.Uniform());
        const float forward = Scattered(HairBxDF(p), wo, wi)[0];
        p.h = -p.h;
        const float backward = Scattered(HairBxDF(p), wi, wo)[0];
        EXPECT_NEAR(forward, backward, 1e-4f * forward);
    }
}

TEST(Hair, AnEtaOfOneLetsLightPassStraightOn) {
    // No reflection: all light goes on by path 1, in the plane of incidence, at the mirrored inclination.
    const HairBxDF hair(
        {.h = 0.4f, .eta = 1, .sigma_a = SampledSpectrum(0), .beta_m = 0.05f, .beta_n = 0.05f});
    Rng rng(SeedOf(FullTestName()));
    const Vec3 wo = Direction(0.3f, 1);
    Vec3 mean(0);
    for (int i = 0; i < 4000; ++i) {
        const auto s = hair.Sample(wo, {rng.Uniform(), rng.Uniform2D()}, {});
        if (!s) continue;
        EXPECT_NEAR(s->weight[0], 1, 1e-4f);
        mean += s->wi / 4000.f;
    }
    EXPECT_LT(Length(mean + wo), 0.02f);
}

TEST(Hair, ReflectionLeavesAtTwiceTheAngleOfIncidence) {
    // So dark inside that nothing else is left; the lobe of path 0 is at -2 asin(h), and turned by -2 alpha.
    const float h = 0.5f, alpha = 0.05f;
    const HairBxDF hair(
        {.h = h, .sigma_a = SampledSpectrum(1e4f), .beta_m = 0.05f, .beta_n = 0.05f, .alpha = alpha});
    const float theta = 0.2f, phi = 0.7f;
    const Vec3 wo = Direction(theta, phi), peak = Direction(-theta + 2 * alpha, phi - 2 * std::asin(h));
    const float most = Scattered(hair, wo, peak)[0];
    for (const float d : {-0.02f, 0.02f}) {
        EXPECT_LT(Scattered(hair, wo, Direction(-theta + 2 * alpha + d, phi - 2 * std::asin(h)))[0], most);
        EXPECT_LT(Scattered(hair, wo, Direction(-theta + 2 * alpha, phi - 2 * std::asin(h) + d))[0], most);
    }
    // Its mass is the Fresnel reflectance.
    Rng rng(SeedOf(FullTestName()));
    RunningMean mass;
    for (int i = 0; i < 2000; ++i)
        if (const auto s = hair.Sample(wo, {rng.Uniform(), rng.Uniform2D()}, {}))
            mass.Add(double(s->weight[0]));
    const float cosGamma = std::sqrt(1 - h * h);
    EXPECT_NEAR(mass.Mean(), double(FresnelDielectric(std::cos(theta) * cosGamma, 1.55f)), 1e-4);
}

TEST(Hair, ColorsAndPigmentsAreThoseOfTheFits) {
    // White absorbs nothing, black as much as there is; a value by hand for a grey.
    const SampledSpectrum sigma = HairBxDF::SigmaAFromReflectance(Lanes(0, 0.25f, 0.5f, 1), 0.3f);
    EXPECT_EQ(sigma[3], 0);
    EXPECT_EQ(sigma[0], 1e6f);
    const double scale =
        5.969 - 0.215 * 0.3 + 2.532 * 0.09 - 10.73 * 0.027 + 5.574 * 0.0081 + 0.245 * 0.00243;
    EXPECT_NEAR(double(sigma[2]), std::pow(std::log(0.5) / scale, 2), 1e-6);
    EXPECT_GT(sigma[1], sigma[2]);
    EXPECT_LT(Length(HairBxDF::SigmaAFromMelanin(1.3f, 0) - Vec3(0.5447f, 0.9061f, 1.781f)), 1e-5f);
    EXPECT_LT(Length(HairBxDF::SigmaAFromMelanin(0, 2) - Vec3(0.374f, 0.8f, 2.1f)), 1e-5f);
}

TEST(Hair, ExtremeParametersGiveFiniteAnswers) {
    Rng rng(SeedOf(FullTestName()));
    for (const float h : {-1.f, 0.f, 1.f})
        for (const float eta : {1e-3f, 0.8f, 1.f, 1e3f})
            for (const float beta : {0.01f, 1.f})
                for (const float sigma : {0.f, 1e6f}) {
                    const HairBxDF hair({h, eta, SampledSpectrum(sigma), beta, beta, 3.f});
                    for (int i = 0; i < 50; ++i) {
                        Vec3 wo = SampleUniformSphere(rng.Uniform2D());
                        if (i % 5 == 0) wo = Normalize(Vec3(1, 0, i % 2 ? 1e-4f : -1e-20f));
                        const BxDFValue v = hair.Evaluate(wo, SampleUniformSphere(rng.Uniform2D()), {});
                        ASSERT_TRUE(v.f.IsValid() && v.pdf >= 0 && std::isfinite(v.pdf));
                        const auto s = hair.Sample(wo, {rng.Uniform(), rng.Uniform2D()}, {});
                        if (!s) continue;
                        ASSERT_TRUE(s->weight.IsValid() && s->pdf > 0 && std::isfinite(s->pdf));
                        // Draws by the attenuations weigh no more than their largest ratio to the mean.
                        ASSERT_LE(s->weight.MaxComponent(), 1 + 1e-3f);
                        ASSERT_NEAR(Length(s->wi), 1, 1e-5f);
                    }
                }
}

}  // namespace
}  // namespace lacquer::hair_test
