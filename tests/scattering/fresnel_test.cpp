#include "pbrt/scattering/fresnel.h"

#include <gtest/gtest.h>

#include <complex>

namespace lacquer::fresnel_test {
namespace {

TEST(FresnelDielectric, KnownPoints) {
    EXPECT_NEAR(FresnelDielectric(1, 1.5f), 0.04f, 1e-7f);
    EXPECT_EQ(FresnelDielectric(0, 1.5f), 1);
    EXPECT_NEAR(FresnelDielectric(0.3f, 1), 0, 1e-12f);
    // Brewster's angle, tan = eta: only the perpendicular part is left, ((eta^2-1)/(eta^2+1))^2 / 2.
    const float brewster = std::cos(std::atan(1.5f));
    EXPECT_NEAR(FresnelDielectric(brewster, 1.5f), 0.5f * Sqr(1.25f / 3.25f), 1e-6f);
    // Beyond the critical angle everything is reflected: cos < sqrt(1 - 1/eta^2) = 0.745 from inside.
    EXPECT_EQ(FresnelDielectric(-0.74f, 1.5f), 1);
    EXPECT_LT(FresnelDielectric(-0.75f, 1.5f), 1);
}

TEST(FresnelDielectric, IsTheSameFromBothSidesOfTheRefractedRay) {
    for (float c = 0.01f; c < 1; c += 0.01f) {
        const auto refracted = Refract({std::sqrt(1 - c * c), 0, c}, {0, 0, 1}, 1.5f);
        ASSERT_TRUE(refracted);
        EXPECT_NEAR(FresnelDielectric(c, 1.5f), FresnelDielectric(refracted->w.z, 1.5f), 1e-4f);
    }
}

TEST(FresnelConductor, AgreesWithComplexArithmetic) {
    using Complex = std::complex<double>;
    for (const float eta : {0.05f, 0.2f, 1.f, 1.5f, 4.f})
        for (const float k : {0.f, 0.1f, 2.f, 8.f})
            for (float c = 0.01f; c <= 1; c += 0.05f) {
                const double cosine = double(c), sin2 = 1 - cosine * cosine;
                const Complex n{double(eta), double(k)}, t = std::sqrt(1. - sin2 / (n * n));
                const Complex parallel = (n * cosine - t) / (n * cosine + t),
                              perpendicular = (cosine - n * t) / (cosine + n * t);
                const double expected = 0.5 * (std::norm(parallel) + std::norm(perpendicular));
                const SampledSpectrum f = FresnelConductor(c, SampledSpectrum(eta), SampledSpectrum(k));
                EXPECT_NEAR(double(f[2]), expected, 3e-5) << eta << ' ' << k << ' ' << c;
            }
}

TEST(FresnelConductor, StaysFiniteAtExtremes) {
    for (const float eta : {0.f, 1e-20f, 1.f, 1e6f})
        for (const float k : {0.f, 1e-20f, 1.f, 1e6f})
            for (const float c : {0.f, 1e-20f, 0.5f, 1.f, 1.0000001f}) {
                const SampledSpectrum f = FresnelConductor(c, SampledSpectrum(eta), SampledSpectrum(k));
                EXPECT_TRUE(f.IsValid() && f.MaxComponent() <= 1) << eta << ' ' << k << ' ' << c;
            }
}

TEST(DiffuseReflectance, IsTheIntegralOfFresnelsFactor) {
    for (const float eta : {0.4f, 0.9f, 1.001f, 1.05f, 1.5f, 2.5f, 10.f}) {
        constexpr int kSteps = 200000;
        double above = 0, below = 0;
        for (int i = 0; i < kSteps; ++i) {
            const float c = (float(i) + 0.5f) / kSteps;
            above += 2 * double(c * FresnelDielectric(c, eta)) / kSteps;
            below += 2 * double(c * FresnelDielectric(-c, eta)) / kSteps;
        }
        const DiffuseFresnel r = DiffuseReflectance(eta);
        EXPECT_NEAR(double(r.fromAbove), above, 2e-6) << eta;
        EXPECT_NEAR(double(r.fromBelow), below, 2e-6) << eta;
    }
    EXPECT_EQ(DiffuseReflectance(1).fromBelow, 0);
}

TEST(Refract, FollowsSnellAndStaysUnit) {
    for (float c = 0.02f; c < 1; c += 0.02f)
        for (const float side : {1.f, -1.f}) {
            const Vec3 w{std::sqrt(1 - c * c), 0, side * c};
            const auto r = Refract(w, {0, 0, 1}, 1.33f);
            if (!r) {
                EXPECT_GT(w.x * 1.33f, 1);
                continue;
            }
            EXPECT_LT(r->w.z * w.z, 0);
            EXPECT_NEAR(Length(r->w), 1, 1e-6f);
            EXPECT_NEAR(r->eta, side > 0 ? 1.33f : 1 / 1.33f, 1e-6f);
            EXPECT_NEAR(-r->w.x * r->eta, w.x, 1e-6f);
        }
}

}  // namespace
}  // namespace lacquer::fresnel_test
