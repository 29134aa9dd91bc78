#include "pbrt/core/transform.h"

#include <gtest/gtest.h>

#include "pbrt/core/rng.h"
#include "support/statistics.h"

namespace lacquer::transform_test {
namespace {

using test::FullTestName;
using test::SeedOf;

Vec3 RandomVector(Rng& rng, float extent = 1) {
    return extent * (2.f * Vec3(rng.Uniform(), rng.Uniform(), rng.Uniform()) - 1.f);
}
/// Invertible, with scales between 1/3 and 3.
Transform RandomAffine(Rng& rng) {
    const Vec3 scale(std::exp(rng.Uniform()), std::exp(-rng.Uniform()), std::exp(rng.Uniform() - 0.5f));
    return Transform::Translate(RandomVector(rng, 10)) *
           Transform::Rotate(360 * rng.Uniform(), RandomVector(rng)) * Transform::Scale(scale) *
           Transform::Rotate(360 * rng.Uniform(), RandomVector(rng));
}
float Distance(Vec3 a, Vec3 b) { return Length(a - b); }
float Difference(const Transform& a, const Transform& b) {
    float d = 0;
    for (int c = 0; c < 4; ++c)
        for (int r = 0; r < 4; ++r) d = std::max(d, std::abs(a.Matrix()[c][r] - b.Matrix()[c][r]));
    return d;
}

TEST(Transform, InverseUndoesPointsVectorsAndNormals) {
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 200; ++i) {
        const Transform t = RandomAffine(rng);
        const Transform fromMatrix(t.Matrix());
        const Vec3 v = RandomVector(rng, 5);
        // A few roundings of numbers up to 30, stretched by the inverse's scale of at most 3 squared.
        const float tolerance = 30 * 9 * Gamma(20);
        EXPECT_LT(Distance(t.InversePoint(t.Point(v)), v), tolerance);
        EXPECT_LT(Distance(t.InverseVector(t.Vector(v)), v), tolerance);
        EXPECT_LT(Distance(t.InverseNormal(t.Normal(v)), v), tolerance);
        EXPECT_LT(Distance(fromMatrix.InversePoint(t.Point(v)), v), tolerance);
        EXPECT_LT(Distance((t.Inverse() * t).Point(v), v), tolerance);
        const Ray ray = t.InverseRay(t.Ray({v, {0, 0, 1}, 0.25f}));
        EXPECT_LT(Distance(ray.o, v), tolerance);
        EXPECT_EQ(ray.time, 0.25f);
    }
}

TEST(Transform, InversesAreThoseOfDoublePrecision) {
    Rng rng(SeedOf(FullTestName()));
    // In units of the last place of the larger number.
    const auto difference = [](const glm::mat4& a, const glm::mat4& b) {
        float most = 0;
        for (int c = 0; c < 4; ++c)
            for (int r = 0; r < 4; ++r)
                most = std::max(
                    most, std::abs(a[c][r] - b[c][r]) /
                              (MachineEpsilon * std::max({std::abs(a[c][r]), std::abs(b[c][r]), 1e-6f})));
        return most;
    };
    float mostOfFloat = 0;
    for (int i = 0; i < 500; ++i) {
        glm::mat4 m = (Transform::Translate(RandomVector(rng, 1e5f)) * RandomAffine(rng)).Matrix();
        if (i % 2) m[i / 2 % 4][3] += 0.25f;  // every other one is projective
        const glm::mat4 exact = glm::mat4(glm::inverse(glm::dmat4(m)));
        EXPECT_LE(difference(Transform(m).Inverse().Matrix(), exact), 2.f) << i;
        if (i % 2 == 0) mostOfFloat = std::max(mostOfFloat, difference(glm::inverse(m), exact));
    }
    EXPECT_GT(mostOfFloat, 10.f);
}

TEST(Transform, ProductsApplyTheRightFactorFirst) {
    const Transform t = Transform::Translate({1, 0, 0}) * Transform::Scale({2, 2, 2});
    EXPECT_EQ(t.Point({1, 1, 1}), Point3(3, 2, 2));
    EXPECT_EQ(t.Vector({1, 1, 1}), Vec3(2, 2, 2));
}

TEST(Transform, NormalsStayPerpendicularToTheirSurface) {
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 100; ++i) {
        const Transform t = RandomAffine(rng);
        const Vec3 a = RandomVector(rng), b = RandomVector(rng);
        const Normal3 n = t.Normal(Cross(a, b));
        EXPECT_NEAR(Dot(Normalize(n), Normalize(t.Vector(a))), 0, 2e-5f);
        EXPECT_NEAR(Dot(Normalize(n), Normalize(t.Vector(b))), 0, 2e-5f);
    }
}

TEST(Transform, ProjectivePointsAreDividedByW) {
    glm::mat4 m(1.f);
    m[2][3] = 1;  // w = z + 1
    EXPECT_EQ(Transform(m).Point({2, 4, 1}), Point3(1, 2, 0.5f));
}

TEST(Transform, RotateFollowsRodrigues) {
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 100; ++i) {
        const float degrees = 720 * rng.Uniform() - 360;
        const Vec3 axis = 7.f * RandomVector(rng), v = RandomVector(rng);
        const Vec3 a = Normalize(axis);
        const float c = std::cos(Radians(degrees)), s = std::sin(Radians(degrees));
        const Vec3 expected = c * v + s * Cross(a, v) + (1 - c) * Dot(a, v) * a;
        EXPECT_LT(Distance(Transform::Rotate(degrees, axis).Vector(v), expected), 4e-6f);
    }
    EXPECT_LT(Distance(Transform::Rotate(90, {0, 0, 1}).Vector({1, 0, 0}), {0, 1, 0}), 1e-7f);
}

TEST(Transform, LookAtHasTheAxesOfTheFormat) {
    bool valid = false;
    const Point3 eye(1, 2, 3), look(4, -1, 5);
    const Vec3 up(0.2f, 3, -0.4f);
    const Transform cameraFromWorld = Transform::LookAt(eye, look, up, &valid);
    ASSERT_TRUE(valid);
    const Vec3 forward = Normalize(look - eye), right = Normalize(Cross(up, forward));
    EXPECT_LT(Length(cameraFromWorld.Point(eye)), 2e-6f);
    EXPECT_LT(Distance(cameraFromWorld.Vector(forward), {0, 0, 1}), 1e-6f);
    EXPECT_LT(Distance(cameraFromWorld.Vector(right), {1, 0, 0}), 1e-6f);
    EXPECT_LT(Distance(cameraFromWorld.Vector(Cross(forward, right)), {0, 1, 0}), 1e-6f);
    EXPECT_LT(Distance(cameraFromWorld.InversePoint({0, 0, 0}), eye), 1e-6f);

    // Straight ahead with +y up is the identity: camera space is what pbrt calls left-handed.
    EXPECT_EQ(Difference(Transform::LookAt({0, 0, 0}, {0, 0, 1}, {0, 1, 0}, &valid), Transform()), 0);
}

TEST(Transform, LookAtRefusesDegenerateViews) {
    bool valid = true;
    EXPECT_TRUE(Transform::LookAt({1, 1, 1}, {1, 1, 1}, {0, 1, 0}, &valid).IsIdentity());
    EXPECT_FALSE(valid);
    Transform::LookAt({0, 0, 0}, {1, 1, 1}, {2, 2, 2}, &valid);
    EXPECT_FALSE(valid);
    Transform::LookAt({0, 0, 0}, {0, 1, 0}, {0, -3, 0}, &valid);
    EXPECT_FALSE(valid);
    Transform::LookAt({0, 0, 0}, {0, 1, 0}, {0, 0, 0}, &valid);
    EXPECT_FALSE(valid);
    Transform::LookAt({0, 0, 0}, {0, 1, 0}, {NAN, 0, 0}, &valid);
    EXPECT_FALSE(valid);
}

TEST(Transform, SingularMatricesAreFound) {
    EXPECT_FALSE(Transform().IsSingular());
    EXPECT_FALSE(Transform::Scale({1e-6f, 1e-6f, 1e-6f}).IsSingular());
    EXPECT_FALSE(Transform::Scale({-1, 1, 1}).IsSingular());
    EXPECT_TRUE(Transform::Scale({1, 0, 1}).IsSingular());
    EXPECT_TRUE(Transform::Scale({1, NAN, 1}).IsSingular());
    EXPECT_TRUE(Transform::Translate({Infinity, 0, 0}).IsSingular());
    EXPECT_TRUE(Transform::Scale({1e-39f, 1, 1}).IsSingular());  // the inverse has no float
    EXPECT_TRUE(Transform::Rotate(30, {0, 0, 0}).IsSingular());
    glm::mat4 rankTwo(1.f);
    rankTwo[1] = rankTwo[0];
    EXPECT_TRUE(Transform(rankTwo).IsSingular());
}

TEST(Transform, ScalesAndMirroringsAreNoticed) {
    EXPECT_FALSE(Transform::Rotate(33, {1, 2, 3}).HasScale());
    EXPECT_FALSE((Transform::Translate({5, 6, 7}) * Transform::Scale({-1, 1, 1})).HasScale());
    EXPECT_TRUE((Transform::Rotate(33, {1, 2, 3}) * Transform::Scale({1, 1.01f, 1})).HasScale());
    EXPECT_TRUE(Transform::Scale({1, 1, -2}).SwapsHandedness());
    EXPECT_FALSE((Transform::Scale({-1, 1, -1}) * Transform::Rotate(10, {0, 1, 0})).SwapsHandedness());
}

TEST(Transform, BoundsHoldTheTransformedBox) {
    const Bounds3 box = Transform::Rotate(45, {0, 0, 1}).Bounds({{-1, -1, 0}, {1, 1, 2}});
    EXPECT_NEAR(box.max.x, std::sqrt(2.f), 1e-6f);
    EXPECT_NEAR(box.min.y, -std::sqrt(2.f), 1e-6f);
    EXPECT_EQ(box.max.z, 2);
}

TEST(AnimatedTransform, StandsStillWithoutMotion) {
    const Transform t = Transform::Translate({1, 2, 3});
    const AnimatedTransform still(t, 0, t, 1);
    EXPECT_FALSE(still.IsAnimated());
    EXPECT_TRUE(still.At(0.5f) == t);
}

TEST(AnimatedTransform, TranslationIsLinearAndClampedAtItsEnds) {
    const AnimatedTransform moving(Transform::Translate({0, 2, 0}), 1, Transform::Translate({4, 0, 8}), 3);
    ASSERT_TRUE(moving.IsAnimated());
    EXPECT_LT(Distance(moving.At(1.5f).Point({0, 0, 0}), {1, 1.5f, 2}), 1e-6f);
    EXPECT_EQ(moving.At(0).Point({0, 0, 0}), Point3(0, 2, 0));
    EXPECT_EQ(moving.At(9).Point({0, 0, 0}), Point3(4, 0, 8));
}

TEST(AnimatedTransform, RotationKeepsItsSpeedAlongTheShorterArc) {
    struct Case {
        float startDeg, endDeg, middleDeg;
    };
    // The third turns by 200 degrees as a number, but by -160 as a motion.
    for (const Case c : {Case{0, 90, 45}, Case{0, 350, -5}, Case{-100, 100, 180}, Case{20, -60, -20}}) {
        const Vec3 axis(1, -2, 0.5f);
        const AnimatedTransform turning(Transform::Rotate(c.startDeg, axis), 0,
                                        Transform::Rotate(c.endDeg, axis), 1);
        EXPECT_LT(Difference(turning.At(0.5f), Transform::Rotate(c.middleDeg, axis)), 2e-6f) << c.endDeg;
        float arc = c.endDeg - c.startDeg;
        if (arc > 180) arc -= 360;
        EXPECT_LT(Difference(turning.At(0.2f), Transform::Rotate(c.startDeg + 0.2f * arc, axis)), 2e-6f)
            << c.endDeg;
    }
}

TEST(AnimatedTransform, ScaleIsLinearByComponent) {
    const AnimatedTransform growing(Transform::Scale({1, 2, 1}), 0, Transform::Scale({3, 1, 1}), 1);
    EXPECT_LT(Distance(growing.At(0.25f).Vector({1, 1, 1}), {1.5f, 1.75f, 1}), 1e-6f);
}

TEST(AnimatedTransform, PartsMoveIndependently) {
    const auto at = [](float t) {
        return Transform::Translate({4 * t, 0, 1}) * Transform::Rotate(80 * t, {0, 1, 1}) *
               Transform::Scale({1 + t, 1, 1 - 0.5f * t});
    };
    const AnimatedTransform moving(at(0), 0, at(1), 1);
    for (const float t : {0.1f, 0.37f, 0.5f, 0.9f}) EXPECT_LT(Difference(moving.At(t), at(t)), 5e-6f) << t;
}

TEST(AnimatedTransform, MirroredKeysAreMetAndStayMirrored) {
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 50; ++i) {
        const Transform mirror =
            Transform::Scale({i % 3 == 0 ? -1.f : 1.f, i % 3 == 1 ? -1.f : 1.f, i % 3 == 2 ? -1.f : 1.f});
        const Transform start = RandomAffine(rng) * mirror;
        const Transform end = Transform::Translate({1, 0, 0}) *
                              Transform::Rotate(70 * rng.Uniform(), RandomVector(rng)) * start;
        const AnimatedTransform moving(start, 0, end, 1);
        // Just inside of its ends the decomposed motion is the keys themselves, up to 1e-5 of numbers
        // below 50.
        EXPECT_LT(Difference(moving.At(1e-6f), start), 1e-3f);
        EXPECT_LT(Difference(moving.At(1 - 1e-6f), end), 1e-3f);
        for (int k = 0; k <= 20; ++k) EXPECT_TRUE(moving.At(float(k) / 20).SwapsHandedness());
    }
}

TEST(AnimatedTransform, MotionBoundsHoldEveryMoment) {
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 40; ++i) {
        const AnimatedTransform moving(RandomAffine(rng), 0.5f, RandomAffine(rng), 2);
        // From nearly a point, far from the axis of rotation, to large boxes.
        const Point3 center = RandomVector(rng, 20);
        const Bounds3 box(center, center + RandomVector(rng, i % 2 ? 5.f : 1e-3f));
        const Bounds3 bounds = moving.MotionBounds(box);
        for (int k = 0; k < 500; ++k) {
            const Transform t = moving.At(0.4f + 1.7f * rng.Uniform());
            for (int corner = 0; corner < 8; ++corner)
                ASSERT_TRUE(bounds.Contains(t.Point(box.Corner(corner))));
        }
    }
}

}  // namespace
}  // namespace lacquer::transform_test
