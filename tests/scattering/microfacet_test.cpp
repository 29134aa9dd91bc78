// Both distributions of normals: normalisations, and the warp of visible normals as a set of three.
#include "pbrt/scattering/microfacet.h"

#include <gtest/gtest.h>

#include "pbrt/core/rng.h"
#include "pbrt/core/sampling.h"
#include "support/statistics.h"

namespace lacquer::microfacet_test {
namespace {

template <class Distribution>
class Microfacet : public testing::Test {};
using Distributions = testing::Types<TrowbridgeReitz, Beckmann>;
TYPED_TEST_SUITE(Microfacet, Distributions);

constexpr std::pair<float, float> kAlphas[] = {{0.1f, 0.1f}, {0.5f, 0.5f}, {1, 1}, {0.2f, 0.6f}};
const Vec3 kViews[] = {{0, 0, 1}, {0.6f, 0, 0.8f}, {-0.48f, 0.64f, 0.6f}, {0.02f, -0.9985f, 0.0509f}};

// Midpoint rule over the tangent of theta (theta = atan of a stretched variable resolves narrow and wide
// lobes alike).
template <class Function>
double HemisphereIntegral(float alpha, const Function& f) {
    constexpr int kN = 700, kM = 360;
    double sum = 0;
    for (int i = 0; i < kN; ++i) {
        // tan theta = alpha s/(1-s) covers [0, inf).
        const double s = (i + 0.5) / kN, t = double(alpha) * s / (1 - s);
        const double dt = double(alpha) / ((1 - s) * (1 - s)) / kN;
        const double c2 = 1 / (1 + t * t), c = std::sqrt(c2), sine = t * c;
        for (int j = 0; j < kM; ++j) {
            const double phi = 2 * M_PI * (j + 0.5) / kM;
            const Vec3 w{float(sine * std::cos(phi)), float(sine * std::sin(phi)), float(c)};
            sum += double(f(w)) * sine * c2 * dt * 2 * M_PI / kM;
        }
    }
    return sum;
}

TYPED_TEST(Microfacet, ProjectedAreaOfAllFacetsIsOne) {
    for (const auto& [x, y] : kAlphas) {
        const TypeParam d(x, y);
        EXPECT_NEAR(HemisphereIntegral(std::max(x, y), [&](Vec3 m) { return d.D(m) * m.z; }), 1, 2e-4);
    }
}

// The definition of masking: what is visible of the facets fills the projected surface [Heitz 2014] eq. 14.
// Facets that face away count nothing, so this ties Lambda to D. The clamp makes a kink: tolerance 5e-4.
TYPED_TEST(Microfacet, VisibleNormalsIntegrateToOne) {
    for (const auto& [x, y] : kAlphas)
        for (const Vec3 view : kViews) {
            const TypeParam d(x, y);
            const Vec3 w = Normalize(view);
            EXPECT_NEAR(HemisphereIntegral(std::max(x, y), [&](Vec3 m) { return PdfVisible(d, w, m); }), 1,
                        5e-4)
                << x << ' ' << y << ' ' << w.z;
        }
}

TYPED_TEST(Microfacet, InvertUndoesSampling) {
    Rng rng(1);
    for (const auto& [x, y] : kAlphas)
        for (const Vec3 view : kViews) {
            const TypeParam d(x, y);
            const Vec3 w = Normalize(view);
            for (int i = 0; i < 1000; ++i) {
                const Point2 u = rng.Uniform2D();
                const Vec3 wm = d.SampleVisible(w, u);
                ASSERT_GE(wm.z, 0);
                // A normal on the horizon has an infinite slope.
                if (wm.z < 1e-3f) continue;
                const Point2 v = d.InvertVisible(w, wm);
                const float dx = std::abs(u.x - v.x);
                // An angle is periodic; where the other coordinate is tiny it has no digits.
                EXPECT_LT(std::min(dx, 1 - dx) * std::min(1.f, 100 * u.y), 2e-4f) << u.x << ' ' << v.x;
                EXPECT_NEAR(u.y, v.y, 2e-4f);
            }
        }
}

// 1/|det J| by central differences is the pdf: no noise, and every missing factor shows.
TYPED_TEST(Microfacet, JacobianOfSamplingIsThePdf) {
    Rng rng(2);
    constexpr float kH = 4e-3f;
    for (const auto& [x, y] : kAlphas)
        for (const Vec3 view : kViews) {
            const TypeParam d(x, y);
            const Vec3 w = Normalize(view);
            for (int i = 0; i < 200; ++i) {
                const Point2 u = Point2(0.1f) + 0.8f * rng.Uniform2D();
                const auto at = [&](float du, float dv) { return d.SampleVisible(w, u + Point2(du, dv)); };
                const auto area = [&](float h) {
                    return Length(Cross((at(h, 0) - at(-h, 0)) / (2 * h), (at(0, h) - at(0, -h)) / (2 * h)));
                };
                // Richardson's extrapolation leaves an error of h^4.
                const float extrapolated = (4 * area(kH / 2) - area(kH)) / 3;
                const float pdf = PdfVisible(d, w, at(0, 0));
                EXPECT_NEAR(extrapolated * pdf, 1, 0.02f)
                    << x << ' ' << y << ' ' << w.z << ' ' << u.x << ' ' << u.y;
            }
        }
}

// Normals drawn from `drawn` are uniform numbers to the inverse of `d`. Power: alphas
// that are 5 % off are found for certain (the control).
template <class Distribution>
test::Outcome UniformAfterInversion(const Distribution& d, const Distribution& drawn, Vec3 w, uint64_t seed) {
    constexpr size_t kCells = 16;
    constexpr int kSamples = 200000;
    std::vector<double> observed(kCells * kCells), expected(kCells * kCells, double(kSamples) / Sqr(kCells));
    Rng rng(seed);
    for (int i = 0; i < kSamples; ++i) {
        const Point2 u = d.InvertVisible(w, drawn.SampleVisible(w, rng.Uniform2D(), rng));
        const auto cell = [](float x) { return size_t(std::clamp(int(x * kCells), 0, int(kCells) - 1)); };
        ++observed[cell(u.y) * kCells + cell(u.x)];
    }
    return test::ChiSquareTest(observed, expected);
}

TYPED_TEST(Microfacet, FreeDrawsHaveTheDistributionOfOrderedOnes) {
    const double alpha = test::SidakAlpha(1e-3, int(std::size(kAlphas) * std::size(kViews)));
    for (const auto& [x, y] : kAlphas)
        for (const Vec3 view : kViews) {
            const TypeParam d(x, y), wider(x * 1.05f, y * 1.05f);
            const Vec3 w = Normalize(view);
            EXPECT_TRUE(test::Passes(test::FullTestName(), alpha,
                                     [&](uint64_t seed) { return UniformAfterInversion(d, d, w, seed); }))
                << x << " " << y << " " << w.z;
            // Control.
            EXPECT_LT(UniformAfterInversion(d, wider, w, test::SeedOf(test::FullTestName())).pValue, alpha);
        }
}

TYPED_TEST(Microfacet, SamplingSurvivesTheCorners) {
    for (const float alpha : {1e-4f, 1e-3f, 1.f, 1e3f})
        for (const Vec3 w :
             {Vec3(0, 0, 1), Vec3(1, 0, 0), Vec3(0.8f, 0.6f, 1e-7f), Vec3(1e-20f, 0, 1), Vec3(0, 1, 1e-20f)})
            for (const float a : {0.f, 0x1p-24f, 0.5f, OneMinusEpsilon})
                for (const float b : {0.f, 0x1p-24f, 0.5f, OneMinusEpsilon}) {
                    const Vec3 wm = TypeParam(alpha, alpha).SampleVisible(w, {a, b});
                    EXPECT_TRUE(IsFinite(wm) && std::abs(Length(wm) - 1) < 1e-5f && wm.z >= 0)
                        << alpha << ' ' << w.z << ' ' << a << ' ' << b;
                }
}

TEST(TrowbridgeReitz, LambdaIsTheFormOfPbrt) {
    const TrowbridgeReitz d(0.3f, 0.7f);
    const Vec3 w = Normalize({0.5f, -0.3f, 0.4f});
    const float alpha2Tan2 = (Sqr(0.3f * w.x) + Sqr(0.7f * w.y)) / (w.z * w.z);
    EXPECT_NEAR(MaskingG1(d, w), 1 / (1 + 0.5f * (std::sqrt(1 + alpha2Tan2) - 1)), 1e-6f);
}

TEST(Beckmann, ProjectedAreaIsSmiths) {
    // The closed form in double precision, over views from the pole to the horizon and alphas of all sizes.
    const auto exact = [](double s, double c) {
        const double a = c / s;
        return 0.5 * (c * (1 + std::erf(a)) + s * std::exp(-a * a) / std::sqrt(M_PI));
    };
    for (const float alpha : {1e-4f, 1e-3f, 0.03f, 0.1f, 0.3f, 1.f, 30.f, 1e3f})
        for (int i = 0; i <= 3000; ++i) {
            const float z = i < 3000 ? std::pow(10.f, -float(i) * 0.004f) : 0.f;
            const Vec3 w(SafeSqrt(1 - z * z), 0, z);
            if (!(w.x > 0)) continue;
            ASSERT_NEAR(double(Beckmann(alpha, alpha).ProjectedArea(w)) /
                            exact(double(alpha) * double(w.x), double(z)),
                        1, 3e-7)
                << alpha << ' ' << z;
        }
}

TEST(Alphas, SmoothAndBoundedAsInTheFormat) {
    EXPECT_TRUE(Alphas(0, 0).IsSmooth());
    EXPECT_TRUE(Alphas(0.00099f, 0).IsSmooth());
    EXPECT_FALSE(Alphas(0.001f, 0).IsSmooth());
    EXPECT_EQ(Alphas(0.5f, 0).y, 1e-4f);
    EXPECT_EQ(Alphas(NAN, -1).x, 1e-4f);
    EXPECT_EQ(Alphas(Infinity, 1).x, 1e3f);
    EXPECT_FLOAT_EQ(RoughnessToAlpha(0.25f), 0.5f);
}

}  // namespace
}  // namespace lacquer::microfacet_test
