// Exit points of subsurface scattering: how densely they are drawn, and what leaves there.
#include "pbrt/bxdfs/tabulated_bssrdf.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "pbrt/bxdfs/normalized_fresnel.h"
#include "support/lanes.h"
#include "support/statistics.h"

namespace lacquer::test::tabulated_bssrdf_test {
namespace {

/// Two media at once: the lanes have different extinctions and albedos, one scatters nothing.
TabulatedBSSRDF MakeExample(Point3 p, Normal3 n) {
    static const std::shared_ptr<const BssrdfTable> table = BssrdfTable::Shared(0, 1.33f);
    return {p, n, 1.33f, Lanes(0.1f, 0.5f, 0.02f, 1), Lanes(0.9f, 2, 3, 0), *table};
}

/// A surface: the distances at which a line meets it, and its normal at a point.
struct TestSurface {
    std::function<std::vector<float>(Point3 o, Vec3 d)> hits;
    std::function<Normal3(Point3)> normal;
};
/// A plane through p.
TestSurface Plane(Point3 p, Normal3 n) {
    return {[=](Point3 o, Vec3 d) { return std::vector<float>{Dot(p - o, n) / Dot(d, n)}; },
            [=](Point3) { return n; }};
}
TestSurface Sphere(Point3 center, float radius) {
    return {[=](Point3 o, Vec3 d) {
                const float b = Dot(o - center, d), under = b * b - DistanceSquared(o, center) + Sqr(radius);
                if (under <= 0) return std::vector<float>();
                return std::vector<float>{-b - std::sqrt(under), -b + std::sqrt(under)};
            },
            [=](Point3 p) { return Normalize(p - center); }};
}

constexpr float kRegionRadius = 2;

/// Draws probes and chooses one of their hits. The mean of count/pdf over the hits that lie nearer to the
/// entry than kRegionRadius is the area of that part of the surface.
RunningMean EstimateArea(const TestSurface& surface, Point3 p, Normal3 shadingNormal, float pdfFactor,
                         uint64_t seed) {
    const TabulatedBSSRDF bssrdf = MakeExample(p, shadingNormal);
    Rng rng(seed);
    RunningMean area;
    for (int i = 0; i < 60000; ++i) {
        double estimate = 0;
        const float uAxis = rng.Uniform();
        if (const auto probe = bssrdf.SampleProbe(uAxis, rng.Uniform2D())) {
            std::vector<Point3> hits;
            for (const float t : surface.hits(probe->start, probe->direction))
                if (t > 0 && t < probe->length) hits.push_back(probe->start + t * probe->direction);
            if (!hits.empty()) {
                const Point3 hit = hits[rng.UniformInt(uint32_t(hits.size()))];
                const float pdf = bssrdf.Evaluate(hit, surface.normal(hit)).pdf[0] * pdfFactor;
                if (DistanceSquared(hit, p) < Sqr(kRegionRadius)) estimate = double(float(hits.size()) / pdf);
            }
        }
        area.Add(estimate);
    }
    return area;
}

constexpr double kAlpha = 1e-4;

// Power: the standard errors are below 1 %; an axis left out changes the result by 10 % or more.
TEST(TabulatedBSSRDF, ProbesOfAPlaneHaveTheDensityThatTheySay) {
    const Point3 p(1, 2, 3);
    for (const float tilt : {0.f, 0.7f, 1.5f}) {
        const Normal3 n = Normalize(Normal3(0.3f, -0.2f, 1));
        const TestSurface plane =
            Plane(p, Normalize(n * std::cos(tilt) + Vec3(1, 0, -0.3f) * std::sin(tilt)));
        EXPECT_TRUE(Passes(FullTestName() + std::to_string(tilt), kAlpha, [&](uint64_t seed) {
            return ZTest(EstimateArea(plane, p, n, 1, seed), double(Pi * Sqr(kRegionRadius)), 1e-3, "area");
        }));
    }
}

// A segment through a sphere has up to two hits; the cap of a sphere has the area pi d^2 for chords up to d.
TEST(TabulatedBSSRDF, ProbesOfASphereHaveTheDensityThatTheySay) {
    const Point3 center(0, 0, 0), p = 1.3f * Normalize(Vec3(1, 2, 2));
    EXPECT_TRUE(Passes(FullTestName(), kAlpha, [&](uint64_t seed) {
        return ZTest(EstimateArea(Sphere(center, 1.3f), p, Normalize(p), 1, seed),
                     double(Pi * Sqr(kRegionRadius)), 1e-3, "area");
    }));
}

TEST(TabulatedBSSRDFControl, ADensityOffByFivePercentIsFound) {
    const Point3 p(0);
    const TestSurface plane = Plane(p, {0, 0, 1});
    EXPECT_LT(ZTest(EstimateArea(plane, p, {0, 0, 1}, 1.05f, SeedOf(FullTestName())),
                    double(Pi * Sqr(kRegionRadius)), 1e-3, "area")
                  .pValue,
              kAlpha);
}

// What leaves a plane in all is the effective albedo in each lane, but for the rim that is not drawn.
TEST(TabulatedBSSRDF, PlanesLetOutTheEffectiveAlbedo) {
    const TabulatedBSSRDF bssrdf = MakeExample({0, 0, 0}, {0, 0, 1});
    const SampledSpectrum expected = bssrdf.EffectiveAlbedo();
    EXPECT_EQ(expected[3], 0);
    for (int lane = 0; lane < 3; ++lane) {
        double sum = 0, within = 0;
        for (double l = std::log(1e-5); l < std::log(200.); l += 1e-3) {
            const double r = std::exp(l);
            const BSSRDFValue v = bssrdf.Evaluate({float(r), 0, 0}, {0, 0, 1});
            sum += 2 * double(Pi) * r * double(v.Sp[lane]) * r * 1e-3;
            within += 2 * double(Pi) * r * double(v.pdf[lane]) * r * 1e-3;
        }
        EXPECT_NEAR(sum, double(expected[lane]), 2e-3 * sum) << lane;
        // Only the probes along the normal, half of them, meet the plane.
        EXPECT_NEAR(within, 0.5, 1e-3) << lane;
    }
}

TEST(TabulatedBSSRDF, ProbesAreChordsOfASphereAroundTheEntry) {
    const Point3 p(1, 2, 3);
    const TabulatedBSSRDF bssrdf = MakeExample(p, Normalize(Vec3(1, 1, 1)));
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 1000; ++i) {
        const float uAxis = rng.Uniform();
        const auto probe = bssrdf.SampleProbe(uAxis, rng.Uniform2D());
        if (!probe) continue;
        EXPECT_NEAR(Length(probe->direction), 1, 1e-5f);
        EXPECT_NEAR(Length(probe->start - p), probe->radius, 1e-4f * probe->radius);
        EXPECT_NEAR(Length(probe->start + probe->length * probe->direction - p), probe->radius,
                    1e-4f * probe->radius);
    }
}

TEST(TabulatedBSSRDF, ExtremeMediaGiveFiniteNumbersOrNothing) {
    const auto table = BssrdfTable::Shared(0, 1.33f);
    for (const float a : {0.f, 1e-12f, 1.f, 1e15f})
        for (const float s : {0.f, 1e-12f, 1.f, 1e15f}) {
            const TabulatedBSSRDF bssrdf({1, 1, 1}, {0, 0, 1}, 1.33f, SampledSpectrum(a), SampledSpectrum(s),
                                         *table);
            EXPECT_TRUE(bssrdf.EffectiveAlbedo().IsValid());
            const auto probe = bssrdf.SampleProbe(0.7f, {0.5f, 0.5f});
            EXPECT_TRUE(s > 0 || !probe);
            if (!probe) continue;
            EXPECT_TRUE(IsFinite(probe->start) && probe->length > 0);
            for (const Point3 p : {Point3(1, 1, 1), Point3(1.1f, 1, 1), Point3(1e6f, 1, 1)}) {
                const BSSRDFValue v = bssrdf.Evaluate(p, {0, 0, 1});
                EXPECT_TRUE(v.Sp.IsValid() && v.pdf.IsValid()) << a << ' ' << s;
            }
        }
}

// The fit of the moment is off by 0.006 of at most 1; the cosine by the midpoint rule.
TEST(NormalizedFresnelBxDF, LetsOutOneInAll) {
    for (const float eta : {0.7f, 1.f, 1.33f, 1.5f, 2.f}) {
        const NormalizedFresnelBxDF bxdf(eta);
        double importance = 0, radiance = 0;
        for (int i = 0; i < 2000; ++i) {
            const float c = (float(i) + 0.5f) / 2000;
            const Vec3 wi(std::sqrt(1 - c * c), 0, c);
            const double scale = 2 * double(Pi) * double(c) / 2000;
            importance +=
                scale * double(bxdf.Evaluate({0, 0, 1}, wi, {.mode = TransportMode::Importance}).f[0]);
            radiance += scale * double(bxdf.Evaluate({0, 0, 1}, wi, {}).f[0]);
        }
        EXPECT_NEAR(importance, 1, 0.025) << eta;
        EXPECT_NEAR(radiance, double(eta * eta) * importance, 1e-5) << eta;
    }
}

TEST(NormalizedFresnelBxDF, SamplesAgreeWithEvaluate) {
    const NormalizedFresnelBxDF bxdf(1.4f);
    Rng rng(SeedOf(FullTestName()));
    for (const float side : {1.f, -1.f})
        for (int i = 0; i < 200; ++i) {
            const auto s = bxdf.Sample({0, 0, side}, {0, rng.Uniform2D()}, {});
            ASSERT_TRUE(s);
            const BxDFValue v = bxdf.Evaluate({0, 0, side}, s->wi, {});
            EXPECT_FLOAT_EQ(s->pdf, v.pdf);
            EXPECT_NEAR(s->weight[1] * s->pdf, v.f[1] * std::abs(s->wi.z), 1e-6f);
        }
    EXPECT_FALSE(bxdf.Evaluate({0, 0, 1}, {0, 0, -1}, {}).f);
    EXPECT_FALSE(bxdf.Sample({0, 0, 1}, {}, {.sides = Lobes::Transmission}));
}

}  // namespace
}  // namespace lacquer::test::tabulated_bssrdf_test
