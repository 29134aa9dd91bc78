// Values of single BxDFs that are known from elsewhere: closed forms, and what pbrt-v4 renders.
#include <gtest/gtest.h>

#include "pbrt/bxdfs/conductor.h"
#include "pbrt/bxdfs/dielectric.h"
#include "pbrt/bxdfs/diffuse.h"
#include "pbrt/bxdfs/diffuse_transmission.h"
#include "support/material_bxdf.h"
#include "support/statistics.h"

namespace lacquer::test::reference_values_test {
namespace {

using GGX = TrowbridgeReitz;

Vec3 At(float degrees) { return {std::sin(Radians(degrees)), 0, std::cos(Radians(degrees))}; }

/// Light that comes back, or through, under a uniform sky of radiance 1.
RunningMean AlbedoOf(const BxDF& bxdf, Vec3 wo) {
    Rng rng(SeedOf(FullTestName()));
    const BxDFContext context{TransportMode::Radiance, Lobes::BothSides, &rng};
    RunningMean mean;
    for (int i = 0; i < 400000; ++i) {
        const float lobe = rng.Uniform();
        const auto sample = bxdf.Sample(wo, {lobe, rng.Uniform2D()}, context);
        mean.Add(sample ? double(sample->weight[0]) : 0);
    }
    return mean;
}

/// k of the metal with eta = 1 and this reflectance at normal incidence.
SampledSpectrum KOf(float r) { return SampledSpectrum(2 * std::sqrt(r / (1 - r))); }
const ConductorBxDF<GGX> kRoughMetal(Alphas(std::sqrt(0.3f), std::sqrt(0.3f)), SampledSpectrum(1), KOf(0.8f));

// pbrt's values are known to 0.001; ours have a standard error below 0.0008: 3 sigma and that together.
constexpr double kTolerance = 0.0034;

TEST(ReferenceAlbedo, AgreesWithPbrt) {
    EXPECT_NEAR(AlbedoOf(kRoughMetal, At(0)).Mean(), 0.5131, kTolerance);
    EXPECT_NEAR(AlbedoOf(kRoughMetal, At(60)).Mean(), 0.5321, kTolerance);
    const DielectricBxDF<GGX> glass(Alphas(std::sqrt(0.3f), std::sqrt(0.3f)), 1.5f);
    EXPECT_NEAR(AlbedoOf(glass, At(0)).Mean(), 0.4424, kTolerance);
    EXPECT_NEAR(AlbedoOf(glass, At(60)).Mean(), 0.4130, kTolerance);
    const DiffuseTransmissionBxDF sheet(SampledSpectrum(0.25f), SampledSpectrum(0.25f));
    EXPECT_NEAR(AlbedoOf(sheet, At(0)).Mean(), 0.5, 1e-6);
}

// f cos theta_i, with wo and wi on opposite sides of the normal; printed to four digits.
TEST(ReferenceValue, AgreesWithPbrt) {
    const struct {
        float thetaO, thetaI;
        double diffuse, metal;
    } rows[] = {{0, 45, 0.1125, 0.1101}, {45, 30, 0.1378, 0.2528}, {60, 60, 0.0796, 0.3007}};
    const DiffuseBxDF grey(SampledSpectrum(0.5f));
    for (const auto& row : rows) {
        const Vec3 wo = At(row.thetaO), wi = At(-row.thetaI);
        EXPECT_NEAR(double(grey.Evaluate(wo, wi, {}).f[0] * wi.z), row.diffuse, 2e-4);
        EXPECT_NEAR(double(kRoughMetal.Evaluate(wo, wi, {}).f[0] * wi.z), row.metal, 2e-4);
    }
}

TEST(Dielectric, SmoothGlassAtNormalIncidence) {
    const DielectricBxDF<GGX> glass(Alphas(0, 0), 1.5f);
    const auto reflected = glass.Sample({0, 0, 1}, {0.039f, {0.5f, 0.5f}}, {});
    const auto refracted = glass.Sample({0, 0, 1}, {0.041f, {0.5f, 0.5f}}, {});
    ASSERT_TRUE(reflected && refracted);
    EXPECT_TRUE(reflected->IsReflection());
    EXPECT_NEAR(reflected->pdf, 0.04f, 1e-6f);
    EXPECT_TRUE(refracted->IsTransmission());
    EXPECT_NEAR(refracted->weight[0], 1 / 2.25f, 1e-6f);
    EXPECT_FLOAT_EQ(refracted->eta, 1.5f);
    // From below, radiance gains the factor.
    const auto outward = glass.Sample({0, 0, -1}, {0.041f, {0.5f, 0.5f}}, {});
    ASSERT_TRUE(outward);
    EXPECT_NEAR(outward->weight[0], 2.25f, 1e-5f);
}

TEST(Dielectric, OneSideAloneHasProbabilityOne) {
    const DielectricBxDF<GGX> glass(Alphas(0, 0), 1.5f);
    const auto reflected = glass.Sample({0, 0, 1}, {0.9f, {0.5f, 0.5f}}, {.sides = Lobes::Reflection});
    ASSERT_TRUE(reflected);
    EXPECT_TRUE(reflected->IsReflection());
    EXPECT_EQ(reflected->pdf, 1);
    EXPECT_NEAR(reflected->weight[0], 0.04f, 1e-6f);
    // Total internal reflection leaves nothing to transmit.
    EXPECT_FALSE(glass.Sample({0.8f, 0, -0.6f}, {0.5f, {0.5f, 0.5f}}, {.sides = Lobes::Transmission}));
}

TEST(Dielectric, IndexOneIsNotThere) {
    const DielectricBxDF<Beckmann> nothing(Alphas(0.5f, 0.5f), 1);
    const Vec3 wo = At(70);
    const auto sample = nothing.Sample(wo, {0, {0.5f, 0.5f}}, {});
    ASSERT_TRUE(sample);
    EXPECT_EQ(sample->wi, -wo);
    EXPECT_EQ(sample->weight, SampledSpectrum(1));
    EXPECT_EQ(sample->eta, 1);
}

TEST(ThinDielectric, SumsTheBouncesInside) {
    Arena arena;
    const BxDF& glass =
        *MaterialFromText(R"("thindielectric" "float eta" 1.5)").MakeBxDF(SampledWavelengths(), arena);
    // R = 0.04: 2R/(1+R) = 1/13.
    const auto sample = glass.Sample({0, 0, 1}, {0.07f, {0.5f, 0.5f}}, {});
    ASSERT_TRUE(sample);
    EXPECT_TRUE(sample->IsReflection());
    EXPECT_NEAR(sample->pdf, 1 / 13.f, 1e-6f);
}

TEST(Regularize, WidensNarrowLobesOnly) {
    // The peak of GGX, D(z) = 1/(pi alpha^2), tells alpha.
    const auto alphaOf = [](const BxDF& metal) {
        return std::sqrt(1 / (4 * Pi * metal.Evaluate({0, 0, 1}, {0, 0, 1}, {}).f[0]));
    };
    const struct {
        float before, after;
    } rows[] = {{0, 0.1f}, {0.02f, 0.1f}, {0.1f, 0.2f}, {0.2f, 0.3f}, {0.35f, 0.35f}};
    for (const auto& row : rows) {
        ConductorBxDF<GGX> metal(Alphas(row.before, row.before), SampledSpectrum(0), SampledSpectrum(1));
        metal.Regularize();
        EXPECT_TRUE(IsNonSpecular(metal.Flags()));
        EXPECT_NEAR(alphaOf(metal), row.after, 1e-5f);
    }
}

}  // namespace
}  // namespace lacquer::test::reference_values_test
