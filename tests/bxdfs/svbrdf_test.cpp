// The captured material against its formulas in double precision, and what `conserve` changes.
#include "pbrt/bxdfs/svbrdf.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pbrt/core/sampling.h"

namespace lacquer::svbrdf_test {
namespace {

/// f for one wavelength, as published: with k = alpha / 2 and a constant in each denominator.
double Published(double a, double s, double alpha, Vec3 wo, Vec3 wi) {
    const double e = 1e-6, nv = double(wo.z), nl = double(wi.z);
    const double h[3] = {double(wo.x) + double(wi.x), double(wo.y) + double(wi.y), nv + nl};
    const double length = std::sqrt(h[0] * h[0] + h[1] * h[1] + h[2] * h[2]), nh = h[2] / length;
    const double vh = (double(wo.x) * h[0] + double(wo.y) * h[1] + nv * h[2]) / length;
    const double D = alpha * alpha / (M_PI * std::pow(nh * nh * (alpha * alpha - 1) + 1, 2) + e);
    const double F = s + (1 - s) * std::exp2((-5.55473 * vh - 6.98316) * vh);
    const double k = alpha / 2 + e, G = nv / (nv * (1 - k) + k) * nl / (nl * (1 - k) + k);
    return a * (1 - s) / M_PI + D * F * G / (4 * nv * nl + e);
}

TEST(Svbrdf, IsThePublishedModel) {
    Rng rng(7);
    const BxDFContext context;
    for (const double alpha : {0.01, 0.05, 0.3, 1.})
        for (int i = 0; i < 200; ++i) {
            const double a = double(rng.Uniform()), s = double(rng.Uniform());
            const SvbrdfBxDF bxdf(SampledSpectrum(float(a)), SampledSpectrum(float(s)), float(alpha), false);
            const Vec3 wo = SampleCosineHemisphere(rng.Uniform2D());
            // Half of the pairs meet in the lobe.
            const Vec3 wi = i % 2 ? SampleCosineHemisphere(rng.Uniform2D())
                                  : Normalize(Vec3(-wo.x + 0.02f * rng.Uniform(), -wo.y, wo.z));
            const double expected = Published(a, s, double(float(alpha)), wo, wi);
            // Directions are unit vectors up to an ulp: the lobe moves by that over alpha.
            const double tolerance = (2e-5 + 2e-6 / alpha) * expected;
            EXPECT_NEAR(double(bxdf.Evaluate(wo, wi, context).f[1]), expected, tolerance) << alpha;
        }
}

/// Part of the light from this direction that leaves again.
double Albedo(const SvbrdfBxDF& bxdf, float cosTheta) {
    const Vec3 wo(std::sqrt(1 - cosTheta * cosTheta), 0, cosTheta);
    constexpr int kSteps = 120;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i)
        for (int j = 0; j < kSteps; ++j) {
            const Vec3 wi = SampleCosineHemisphere({(float(i) + 0.5f) / kSteps, (float(j) + 0.5f) / kSteps});
            sum += double(bxdf.Evaluate(wo, wi, {}).f[0]) * M_PI / (kSteps * kSteps);
        }
    return sum;
}

TEST(Svbrdf, ConservingReflectsNoMoreThanArrives) {
    double most = 0;
    for (const float s : {0.f, 0.04f, 0.5f})
        for (const float alpha : {0.2f, 0.5f, 1.f})
            for (const float cosTheta : {0.02f, 0.05f, 0.1f, 0.3f, 0.7f, 1.f}) {
                const SampledSpectrum one(1), specular(s);
                EXPECT_LT(Albedo(SvbrdfBxDF(one, specular, alpha, true), cosTheta), 1.002)
                    << s << ' ' << alpha << ' ' << cosTheta;
                most = std::max(most, Albedo(SvbrdfBxDF(one, specular, alpha, false), cosTheta));
            }
    EXPECT_GT(most, 1.1);
}

// At normal incidence both are the same within Fresnel's factor there, 2^-12.5.
TEST(Svbrdf, ConservingKeepsWhatIsSeenFromAbove) {
    const Vec3 up(0, 0, 1);
    const SampledSpectrum a(0.6f), s(0.04f);
    const float published = SvbrdfBxDF(a, s, 0.3f, false).Evaluate(up, up, {}).f[0];
    EXPECT_NEAR(SvbrdfBxDF(a, s, 0.3f, true).Evaluate(up, up, {}).f[0], published, 4e-4f * published);
}

TEST(Svbrdf, ExtremesStayFinite) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const float alpha : {nan, -1.f, 0.f, 1e30f})
        for (const bool conserve : {false, true}) {
            const SvbrdfBxDF bxdf(SampledSpectrum(0), SampledSpectrum(0), alpha, conserve);
            const BxDFValue value = bxdf.Evaluate({0, 0, 1}, {0, 0, 1}, {});
            EXPECT_TRUE(value.f.IsValid());
            EXPECT_TRUE(std::isfinite(value.pdf));
        }
}

}  // namespace
}  // namespace lacquer::svbrdf_test
