// Facets seen from any side, and flights between them.
#include "pbrt/scattering/microsurface.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "pbrt/core/sampling.h"
#include "support/statistics.h"

namespace lacquer::test::microsurface_test {
namespace {

template <class T>
class Microsurface : public testing::Test {};
using Distributions = testing::Types<TrowbridgeReitz, Beckmann>;
TYPED_TEST_SUITE(Microsurface, Distributions);

/// Integrals of D(m) max(0, w.m) and of that times m.
struct Seen {
    double area = 0, x = 0, y = 0, z = 0;
};
/// By the midpoint rule in tan(theta/2) and phi; error below 1e-4.
template <class Distribution>
Seen Quadrature(const Distribution& facets, Vec3 w) {
    constexpr int kNumTheta = 600, kNumPhi = 240;
    Seen seen;
    for (int i = 0; i < kNumTheta; ++i) {
        const double q = (i + 0.5) / kNumTheta;
        // theta = pi/2 q^2: fine near the pole, where D of small alphas is.
        const double theta = double(PiOver2) * q * q, dTheta = double(Pi) * q / kNumTheta;
        for (int j = 0; j < kNumPhi; ++j) {
            const double phi = 2 * double(Pi) * (j + 0.5) / kNumPhi;
            const Vec3 m = SphericalDirection(float(std::sin(theta)), float(std::cos(theta)), float(phi));
            const double part = double(facets.D(m)) * std::max(0., double(Dot(w, m))) * std::sin(theta) *
                                dTheta * 2 * double(Pi) / kNumPhi;
            seen.area += part;
            seen.x += part * double(m.x);
            seen.y += part * double(m.y);
            seen.z += part * double(m.z);
        }
    }
    return seen;
}

std::vector<Vec3> Views() {
    std::vector<Vec3> views;
    for (const float deg : {0.f, 50.f, 85.f, 90.f, 95.f, 115.f, 140.f})
        views.push_back(SphericalDirection(std::sin(Radians(deg)), std::cos(Radians(deg)), 0.8f));
    return views;
}

TYPED_TEST(Microsurface, AreasAreThoseOfQuadrature) {
    for (const Vec2 alphas : {Vec2(0.3f, 0.3f), Vec2(1, 1), Vec2(0.2f, 0.7f)}) {
        const TypeParam facets(alphas.x, alphas.y);
        for (const Vec3 w : Views()) {
            const FacetAreas areas = AreasOf(facets, w);
            EXPECT_NEAR(areas.front, Quadrature(facets, w).area, 3e-4) << w.z;
            EXPECT_NEAR(areas.back, Quadrature(facets, -w).area, 3e-4) << w.z;
            EXPECT_NEAR(areas.front - areas.back, w.z, 1e-6f);
        }
    }
}

// Power: a mean that is off by 0.5 % of its standard deviation is found.
TYPED_TEST(Microsurface, NormalsSeenFromBelowHaveTheMeansOfTheirDensity) {
    for (const Vec2 alphas : {Vec2(0.5f, 0.5f), Vec2(1, 1), Vec2(0.3f, 0.9f)}) {
        const TypeParam facets(alphas.x, alphas.y);
        for (const Vec3 w : Views()) {
            if (w.z > 0) continue;
            const Seen seen = Quadrature(facets, w);
            const auto check = [&](uint64_t seed) {
                Rng rng(seed);
                RunningMean x, y, z;
                int hidden = 0;
                for (int i = 0; i < Scaled(1000000); ++i) {
                    const Vec3 m = SampleFacet(facets, w, rng);
                    hidden += !(Dot(w, m) > -1e-6f) || !(m.z > 0);
                    x.Add(double(m.x));
                    y.Add(double(m.y));
                    z.Add(double(m.z));
                }
                EXPECT_EQ(hidden, 0);
                const double bias = 1e-3;
                return WorstOf(std::array{ZTest(x, seen.x / seen.area, bias, "x"),
                                          ZTest(y, seen.y / seen.area, bias, "y"),
                                          ZTest(z, seen.z / seen.area, bias, "z")});
            };
            EXPECT_TRUE(
                Passes(fmt::format("{} {} {}", FullTestName(), alphas.x, w.z), SidakAlpha(1e-3, 12), check))
                << w.z;
        }
    }
}

/// Directions of a walk: the first leads in; in, out, and near the horizon.
std::vector<MicroRay> RandomRays(const TrowbridgeReitz& facets, int count, Rng& rng) {
    std::vector<MicroRay> rays;
    for (int i = 0; i < count; ++i) {
        Vec3 d = SampleUniformSphere(rng.Uniform2D());
        if (i == 0) d.z = -std::abs(d.z);
        rays.emplace_back(facets, Normalize({d.x, d.y, 0.5f * d.z}));
    }
    return rays;
}

// The integral over all depths against walks that draw theirs.
TEST(DepthFreePath, LeavesAsOftenAsWalksWithDepths) {
    const TrowbridgeReitz facets(1, 1);
    constexpr int kPaths = 30;
    for (int n = 0; n < kPaths; ++n) {
        const auto check = [&](uint64_t seed) {
            Rng rng(seed);
            const std::vector<MicroRay> rays = RandomRays(facets, 2 + n % 5, rng);
            const MicroRay exit(facets, Normalize({0.8f, 0.1f, rng.Uniform() + 0.05f}));
            DepthFreePath path(rays[0]);
            for (size_t i = 1; i < rays.size(); ++i) path.Append(rays[i]);
            RunningMean escape, survival;
            for (int i = 0; i < Scaled(100000); ++i) {
                MicroDepth depth;
                bool isInside = true;
                for (const MicroRay& ray : rays)
                    if (isInside) isInside = depth.Fly(ray, rng);
                survival.Add(isInside);
                escape.Add(isInside ? double(depth.EscapeOverCosine(exit) * exit.cosine) : 0.);
            }
            return WorstOf(
                std::array{ZTest(escape, double(path.EscapeOverCosine(exit) * exit.cosine), 1e-6, "escape"),
                           ZTest(survival, double(path.Survival()), 1e-6, "survival")});
        };
        EXPECT_TRUE(Passes(fmt::format("{} {}", FullTestName(), n), SidakAlpha(1e-3, kPaths), check));
    }
}

TEST(OppositeShadowing, IsTheBetaFunction) {
    for (const double a : {0., 1e-5, 0.1, 1., 3.7, 60.})
        for (const double b : {0., 1e-3, 0.4, 1., 9., 4000.}) {
            const double expected =
                std::exp(std::lgamma(1 + a) + std::lgamma(1 + b) - std::lgamma(1 + a + b));
            EXPECT_NEAR(double(OppositeShadowingRatio(float(a), float(b))), expected, 1e-5 * expected + 1e-7)
                << a << " " << b;
        }
    // B(2, 2) = 1/6, 1/(1 + 1 + 1) = 1/3.
    EXPECT_NEAR(OppositeShadowingRatio(1, 1), 0.5f, 1e-6f);
    EXPECT_GE(OppositeShadowingRatio(1e30f, 1e30f), 0);
}

}  // namespace
}  // namespace lacquer::test::microsurface_test
