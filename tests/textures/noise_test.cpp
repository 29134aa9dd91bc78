#include "pbrt/textures/noise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "textures/texture_fixture.h"

namespace lacquer::noise_test {
namespace {

using namespace testing_support;

Point3 RandomPoint(uint32_t* state, float range) {
    Point3 p;
    for (int i = 0; i < 3; ++i)
        p[i] = range * (float((*state = *state * 1664525 + 1013904223) >> 8) * 0x1p-23f - 1);
    return p;
}

TEST(Noise, VanishesAtLatticePoints) {
    for (int x = -3; x < 300; x += 7)
        for (int y = -5; y < 5; ++y)
            for (int z = -2; z < 3; ++z) EXPECT_EQ(Noise(Point3(float(x), float(y), float(z))), 0);
}

TEST(Noise, AgreesWithTheReference) {
    // The first two are also values of the published reference implementation; the others have cell corners
    // where pbrt's choice of gradients (hashes 12 to 15) differs from it, and were computed in double
    // precision from the definition.
    EXPECT_NEAR(Noise(Point3(3.14f, 42, 7)), 0.136919959f, 1e-6f);
    EXPECT_NEAR(Noise(Point3(3.14f, 42.3f, 7.8f)), 0.448881195f, 1e-5f);
    EXPECT_NEAR(Noise(Point3(0.5f, 0.5f, 0.5f)), -0.125f, 1e-6f);
    EXPECT_NEAR(Noise(-1.7f, 2.6f), -0.0400396518f, 1e-6f);
}

TEST(Noise, StaysWithinItsRangeAndReachesMostOfIt) {
    uint32_t state = 1;
    float low = 0, high = 0;
    for (int i = 0; i < 100000; ++i) {
        const float n = Noise(RandomPoint(&state, 100));
        low = std::min(low, n);
        high = std::max(high, n);
    }
    EXPECT_GE(low, -1.04f);
    EXPECT_LE(high, 1.04f);
    EXPECT_LT(low, -0.7f);
    EXPECT_GT(high, 0.7f);
}

TEST(Noise, HasAContinuousGradientAcrossCells) {
    // One-sided slopes at a cell face agree; second differences over h = 1e-2 of a twice differentiable
    // function with curvature below 20 differ by less than 20 h.
    uint32_t state = 3;
    for (int i = 0; i < 200; ++i) {
        Point3 p = RandomPoint(&state, 20);
        p.x = std::floor(p.x);
        const float h = 1e-2f, n = Noise(p);
        const float left = (n - Noise(p - Vec3(h, 0, 0))) / h, right = (Noise(p + Vec3(h, 0, 0)) - n) / h;
        EXPECT_NEAR(left, right, 20 * h);
    }
}

TEST(Noise, RepeatsAfter256AndIsFiniteEverywhere) {
    EXPECT_NEAR(Noise(Point3(0.25f, 0.5f, 0.75f)), Noise(Point3(256.25f, 0.5f, -255.25f)), 1e-4f);
    for (const float x : {1e8f, -1e20f, 3e38f, Infinity, -Infinity, std::nanf("")})
        EXPECT_EQ(Noise(Point3(0.3f, x, 0.4f)), 0);
}

TEST(FractionalBrownianMotion, SumsOctaves) {
    const Point3 p(0.3f, 1.7f, -2.2f);
    const float expected = Noise(p) + 0.6f * Noise(1.99f * p) + 0.36f * Noise(1.99f * 1.99f * p);
    EXPECT_NEAR(FractionalBrownianMotion(p, Vec3(0), Vec3(0), {0.6f, 3}), expected, 1e-5f);
    const float turbulence =
        std::abs(Noise(p)) + 0.6f * std::abs(Noise(1.99f * p)) + 0.36f * std::abs(Noise(1.99f * 1.99f * p));
    // All octaves are visible; pbrt adds the mean of the next one on top.
    EXPECT_NEAR(Turbulence(p, Vec3(0), Vec3(0), {0.6f, 3}), turbulence + 0.216f * 0.2f, 1e-5f);
}

TEST(FractionalBrownianMotion, LosesOctavesWithTheFootprint) {
    const Point3 p(0.3f, 1.7f, -2.2f);
    // n = -1 - log2(width): 2 octaves at width 1/8, none at 1/2.
    EXPECT_NEAR(FractionalBrownianMotion(p, Vec3(0.125f, 0, 0), Vec3(0), {0.5f, 8}),
                Noise(p) + 0.5f * Noise(1.99f * p), 1e-5f);
    EXPECT_EQ(FractionalBrownianMotion(p, Vec3(0), Vec3(0, 0.5f, 0), {0.5f, 8}), 0);
    EXPECT_EQ(FractionalBrownianMotion(p, Vec3(0), Vec3(0, 1e30f, 0), {0.5f, 8}), 0);
    // At n = 2.5 the third octave is faded by one half.
    const float width = std::exp2(-3.5f);
    EXPECT_NEAR(FractionalBrownianMotion(p, Vec3(width, 0, 0), Vec3(0), {0.5f, 8}),
                Noise(p) + 0.5f * Noise(1.99f * p) + 0.125f * Noise(1.99f * 1.99f * p), 1e-4f);
    // With no octave visible, turbulence is 0.2 (1 + sum of 0.5^i, i = 0..3): the fading one counts twice.
    EXPECT_NEAR(Turbulence(p, Vec3(1, 0, 0), Vec3(0), {0.5f, 4}), 0.2f * (1 + 1.875f), 1e-5f);
}

TEST(OctaveParams, AreLimited) {
    EXPECT_EQ(OctaveParams::Read(MakeParams({})).octaves, 8);
    EXPECT_EQ(OctaveParams::Read(MakeParams({Integer("octaves", 2147483647)})).octaves, kMaxOctaves);
    EXPECT_THROW(OctaveParams::Read(MakeParams({Integer("octaves", -1)})), SceneError);
    for (const float roughness : {std::nanf(""), Infinity, 1e30f})
        EXPECT_THROW(OctaveParams::Read(MakeParams({Numbers("float", "roughness", {roughness})})),
                     SceneError);
    const Point3 p(0.3f, 1.7f, -2.2f);
    for (const float omega : {-10.f, 10.f}) {
        EXPECT_TRUE(std::isfinite(FractionalBrownianMotion(p, Vec3(0), Vec3(0), {omega, kMaxOctaves})));
        EXPECT_TRUE(std::isfinite(Turbulence(p, Vec3(0), Vec3(0), {omega, kMaxOctaves})));
    }
}

}  // namespace
}  // namespace lacquer::noise_test
