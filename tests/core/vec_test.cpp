#include "pbrt/core/vec.h"

#include <gtest/gtest.h>

#include "pbrt/base/interaction.h"
#include "pbrt/core/rng.h"
#include "support/statistics.h"

namespace lacquer::vec_test {
namespace {

using test::FullTestName;
using test::SeedOf;

Vec3 RandomDirection(Rng& rng) {
    const float z = 2 * rng.Uniform() - 1;
    return SphericalDirection(SafeSqrt(1 - z * z), z, 2 * Pi * rng.Uniform());
}

TEST(Vec, CrossKeepsItsDigitsForNearlyParallelVectors) {
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 200; ++i) {
        const Vec3 a = 100.f * RandomDirection(rng), b = a + 1e-3f * RandomDirection(rng);
        const glm::dvec3 exact = glm::cross(glm::dvec3(a), glm::dvec3(b));
        // Each component errs by at most 1.5 units in its own last place.
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(double(Cross(a, b)[c]), exact[c],
                        4 * double(MachineEpsilon) * std::abs(exact[c]) + 1e-30);
    }
}

TEST(Vec, AngleBetweenIsAccurateNearZeroAndPi) {
    for (const float angle : {1e-4f, 0.3f, 1.5f, 3.f}) {
        const Vec3 a(1, 0, 0), b(std::cos(angle), std::sin(angle), 0);
        EXPECT_NEAR(AngleBetween(a, b), angle, 1e-6f * (1 + angle));
    }
    EXPECT_EQ(AngleBetween({0, 0, 1}, {0, 0, 1}), 0);
    EXPECT_NEAR(AngleBetween({0, 0, 1}, {0, 0, -1}), Pi, 1e-6f);
}

TEST(Frame, IsOrthonormalAndRightHandedEverywhere) {
    Rng rng(SeedOf(FullTestName()));
    std::vector<Vec3> normals = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {0, 1, 0}};
    for (const float tiny : {1e-3f, 1e-5f, 1e-8f}) normals.push_back(Normalize(Vec3(tiny, -tiny, -1)));
    for (int i = 0; i < 500; ++i) normals.push_back(RandomDirection(rng));
    for (const Vec3 n : normals) {
        const Frame f = Frame::FromZ(n);
        EXPECT_EQ(f.z, n);
        for (const auto& [a, b] : {std::pair(f.x, f.y), std::pair(f.y, f.z), std::pair(f.z, f.x)}) {
            EXPECT_NEAR(Dot(a, b), 0, 1e-6f);
            EXPECT_NEAR(Length(a), 1, 1e-6f);
        }
        EXPECT_NEAR(Dot(Cross(f.x, f.y), f.z), 1, 1e-6f);
        const Vec3 v = RandomDirection(rng);
        EXPECT_LT(Length(f.FromLocal(f.ToLocal(v)) - v), 2e-6f);
        EXPECT_NEAR(f.ToLocal(v).z, Dot(v, n), 1e-6f);
    }
}

TEST(Frame, KeepsNormalAndAzimuthOfItsTangent) {
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 200; ++i) {
        const Vec3 n = RandomDirection(rng), tangent = 3.f * RandomDirection(rng);
        const Frame f = Frame::FromZX(n, tangent);
        EXPECT_EQ(f.z, n);
        EXPECT_NEAR(f.ToLocal(tangent).y, 0, 1e-5f);
        EXPECT_GE(f.ToLocal(tangent).x, 0);
        EXPECT_NEAR(Dot(Cross(f.x, f.y), f.z), 1, 1e-5f);
    }
    for (const Vec3 useless : {Vec3(0, 0, 2), Vec3(0), Vec3(NAN, 0, 0), Vec3(Infinity, 0, 0)}) {
        const Frame f = Frame::FromZX({0, 0, 1}, useless);
        EXPECT_NEAR(Dot(Cross(f.x, f.y), f.z), 1, 1e-6f);
    }
}

TEST(EqualAreaMap, RoundTripsBothWays) {
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 2000; ++i) {
        const Point2 p = rng.Uniform2D();
        const Vec3 d = EqualAreaSquareToSphere(p);
        EXPECT_NEAR(Length(d), 1, 1e-6f);
        // 1 - |z| = r^2 loses digits near the poles: an error e of z moves r by e / (2 r), at worst sqrt(e).
        const Point2 q = EqualAreaSphereToSquare(d);
        EXPECT_NEAR(q.x, p.x, 5e-4f);
        EXPECT_NEAR(q.y, p.y, 5e-4f);
        EXPECT_LT(Length(EqualAreaSquareToSphere(q) - d), 1e-3f);
    }
}

TEST(EqualAreaMap, PutsItsPolesAndAxesWhereTheFormatSays) {
    const auto expectNear = [](Vec3 a, Vec3 b) {
        EXPECT_LT(Length(a - b), 1e-6f) << a.x << " " << a.y << " " << a.z;
    };
    expectNear(EqualAreaSquareToSphere({0.5f, 0.5f}), {0, 0, 1});
    for (const Point2 corner : {Point2(0, 0), Point2(1, 0), Point2(0, 1), Point2(1, 1)})
        expectNear(EqualAreaSquareToSphere(corner), {0, 0, -1});
    expectNear(EqualAreaSquareToSphere({1, 0.5f}), {1, 0, 0});
    expectNear(EqualAreaSquareToSphere({0.5f, 1}), {0, 1, 0});
    expectNear(EqualAreaSquareToSphere({0, 0.5f}), {-1, 0, 0});
    EXPECT_EQ(EqualAreaSphereToSquare({0, 0, 1}), Point2(0.5f, 0.5f));
}

TEST(EqualAreaMap, StretchesAllAreasAlike) {
    // |dw/du x dw/dv| = 4 pi by central differences; 1e-3 of the square is wide enough for float rounding
    // (1e-7 / 1e-3) and narrow enough for curvature (1e-6). Cells on the folds are left out.
    constexpr float kStep = 1e-3f;
    Rng rng(SeedOf(FullTestName()));
    int tested = 0;
    for (int i = 0; i < 2000; ++i) {
        const Point2 p = kStep + (1 - 2 * kStep) * rng.Uniform2D();
        const float u = std::abs(2 * p.x - 1), v = std::abs(2 * p.y - 1);
        // Near the poles the curvature grows like 1/r.
        if (std::min({u, v, std::abs(1 - u - v)}) < 4 * kStep || 1 - std::abs(1 - u - v) < 0.1f) continue;
        const Vec3 du =
            EqualAreaSquareToSphere(p + Point2(kStep, 0)) - EqualAreaSquareToSphere(p - Point2(kStep, 0));
        const Vec3 dv =
            EqualAreaSquareToSphere(p + Point2(0, kStep)) - EqualAreaSquareToSphere(p - Point2(0, kStep));
        EXPECT_NEAR(Length(Cross(du, dv)) / Sqr(2 * kStep), 4 * Pi, 0.01f * 4 * Pi) << p.x << " " << p.y;
        ++tested;
    }
    EXPECT_GT(tested, 1500);
}

TEST(EqualAreaMap, ContinuesAcrossItsEdges) {
    constexpr float kStep = 1e-3f;
    for (float along = 0.05f; along < 1; along += 0.1f)
        for (const auto& [inside, outside] :
             {std::pair(Point2(kStep, along), Point2(-kStep, along)),
              std::pair(Point2(1 - kStep, along), Point2(1 + kStep, along)),
              std::pair(Point2(along, kStep), Point2(along, -kStep)),
              std::pair(Point2(along, 1 - kStep), Point2(along, 1 + kStep))}) {
            const Point2 wrapped = WrapEqualAreaSquare(outside);
            EXPECT_TRUE(wrapped.x >= 0 && wrapped.x <= 1 && wrapped.y >= 0 && wrapped.y <= 1);
            // Two steps of kStep in a map that stretches lengths by at most 2 pi.
            EXPECT_LT(Length(EqualAreaSquareToSphere(wrapped) - EqualAreaSquareToSphere(inside)),
                      4 * Pi * kStep);
        }
    EXPECT_EQ(WrapEqualAreaSquare({0.3f, 0.8f}), Point2(0.3f, 0.8f));
}

TEST(OffsetRayOrigin, LeavesTheErrorBoxOnTheSideOfTheRay) {
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 2000; ++i) {
        const Vec3 n = RandomDirection(rng), w = RandomDirection(rng);
        const Point3 p = std::exp(12 * rng.Uniform() - 6) * RandomDirection(rng);
        const float error = Gamma(5) * MaxComponent(Abs(p));
        const glm::dvec3 o(OffsetRayOrigin(p, error, n, w));
        const double side = Dot(w, n) < 0 ? -1 : 1;
        for (int corner = 0; corner < 8; ++corner) {
            const glm::dvec3 c =
                glm::dvec3(p) +
                double(error) * (2.0 * glm::dvec3(corner & 1, corner >> 1 & 1, corner >> 2) - 1.0);
            // The distance |n|_1 e is rounded itself.
            EXPECT_GE(side * glm::dot(o - c, glm::dvec3(n)), -4e-7 * double(error));
        }
        // And not much further: twice the box and one unit in the last place of p.
        EXPECT_LT(glm::length(o - glm::dvec3(p)),
                  2 * double(error) + 4 * double(MachineEpsilon) * glm::length(glm::dvec3(p)));
    }
}

TEST(Bounds, EmptyOnesAreNeutralInUnions) {
    const Bounds3 empty;
    EXPECT_TRUE(empty.IsEmpty());
    EXPECT_EQ(empty.SurfaceArea(), 0);
    const Bounds3 box = empty.Union(Point3(1, 2, 3)).Union(Bounds3({0, 5, 0}, {-1, 3, 2}));
    EXPECT_EQ(box.min, Point3(-1, 2, 0));
    EXPECT_EQ(box.max, Point3(1, 5, 3));
    EXPECT_EQ(box.SurfaceArea(), 2 * (2 * 3 + 2 * 3 + 3 * 3));
    EXPECT_EQ(Bounds3({0, 0, 0}, {1, 3, 2}).MaxDimension(), 1);
    EXPECT_TRUE(box.Contains({0, 3, 1}));
    EXPECT_FALSE(box.Contains({0, 1, 1}));
}

TEST(Bounds, PixelRectanglesAreHalfOpen) {
    const Bounds2i a{{0, 0}, {4, 3}};
    EXPECT_EQ(a.Area(), 12);
    EXPECT_TRUE(a.Contains({3, 2}));
    EXPECT_FALSE(a.Contains({4, 2}));
    EXPECT_EQ(a.Intersect({{2, -1}, {9, 2}}), (Bounds2i{{2, 0}, {4, 2}}));
    EXPECT_EQ(a.Intersect({{5, 5}, {9, 9}}).Area(), 0);
    EXPECT_EQ((Bounds2i{{0, 0}, {1 << 20, 1 << 20}}).Area(), int64_t(1) << 40);
}

}  // namespace
}  // namespace lacquer::vec_test
