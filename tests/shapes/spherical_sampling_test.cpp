// Triangles and rectangles on the sphere of directions: solid angles, and uniform points in them.
#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "pbrt/core/rng.h"
#include "pbrt/shapes/spherical_sampling.h"
#include "support/statistics.h"

namespace lacquer::test::spherical_sampling_test {

namespace {

using glm::dvec3;

double TriangleSolidAngle(Point3 from, Point3 a, Point3 b, Point3 c) {
    return double(SphericalTriangle(from, a, b, c).SolidAngle());
}

/// [Van Oosterom and Strackee 1983], of corners relative to the viewer.
double SolidAngleInDoubles(dvec3 a, dvec3 b, dvec3 c) {
    using glm::dot, glm::length;
    const double volume = std::abs(dot(a, glm::cross(b - a, c - a)));
    const double sum = length(a) * length(b) * length(c) + dot(a, b) * length(c) + dot(b, c) * length(a) +
                       dot(c, a) * length(b);
    return 2 * std::atan2(volume, sum);
}

/// The same as one would write it for floats, without care.
float SolidAngleOfUnitVectors(Vec3 a, Vec3 b, Vec3 c) {
    a = Normalize(a);
    b = Normalize(b);
    c = Normalize(c);
    return 2 * std::atan2(std::abs(Dot(a, Cross(b, c))), 1 + Dot(a, b) + Dot(b, c) + Dot(a, c));
}

/// Never smaller than either; not a number if one is not.
double Worse(double worst, double error) { return std::isnan(worst) || error <= worst ? worst : error; }

/// A viewer and a triangle: of any size, nearly all around or some minutes of arc, well shaped or a sliver,
/// seen from above or at grazing angles.
struct SeenTriangle {
    Point3 from, a, b, c;

    explicit SeenTriangle(Rng& rng) {
        const auto power = [&](float low, float high) {
            return std::pow(10.f, Lerp(rng.Uniform(), low, high));
        };
        const auto around = [&] { return Vec3(rng.Uniform(), rng.Uniform(), rng.Uniform()) - 0.5f; };
        const float unit = power(-15, 15), size = unit * power(-2, 1.5f);
        from = rng.Uniform() < 0.5f ? Point3(0) : unit * around();
        const Point3 center = from + unit * Normalize(around());
        a = center + size * around();
        b = center + size * around();
        c = rng.Uniform() < 0.5f ? center + size * around() : b + 0.02f * size * around();
    }
    dvec3 A() const { return dvec3(a) - dvec3(from); }
    dvec3 B() const { return dvec3(b) - dvec3(from); }
    dvec3 C() const { return dvec3(c) - dvec3(from); }
    double SolidAngle() const { return SolidAngleInDoubles(A(), B(), C()); }
    /// What rounding of the edges counts for: 1, and less for slivers and where the plane is seen at grazing
    /// angles.
    double Condition() const {
        const dvec3 ab = B() - A(), ac = C() - A(), normal = glm::cross(ab, ac);
        const double longest = std::max({glm::length(ab), glm::length(ac), glm::length(C() - B())});
        const double sine = std::abs(glm::dot(A(), normal)) / (glm::length(A()) * glm::length(normal));
        return sine * glm::length(normal) / (longest * longest);
    }
};

}  // namespace

TEST(SphericalTriangle, SolidAnglesAreThoseInDoubles) {
    Rng rng(SeedOf(FullTestName()));
    double worst = 0, worstOfUnitVectors = 0;
    int seen = 0;
    for (int i = 0; i < 200000; ++i) {
        const SeenTriangle t(rng);
        const double expected = t.SolidAngle();
        if (expected < 1e-4 || expected > 6.2) continue;
        ++seen;
        const double scale = t.Condition();
        const auto error = [&](double angle) { return std::abs(angle / expected - 1) * scale; };
        worst = Worse(worst, error(TriangleSolidAngle(t.from, t.a, t.b, t.c)));
        worstOfUnitVectors =
            std::max(worstOfUnitVectors,
                     error(double(SolidAngleOfUnitVectors(t.a - t.from, t.b - t.from, t.c - t.from))));
    }
    EXPECT_GT(seen, 50000);
    EXPECT_LT(worst, 1e-6);
    // Power: the careless form fails by far.
    EXPECT_GT(worstOfUnitVectors, 3e-6);
}

// What the numbers say by construction: the point lies on the arc from B to a point X of A C; A B X has u.x
// of the solid angle, and the point u.y of the height of X over B.
TEST(SphericalTriangle, NumbersAreFractionsOfSolidAngleAndHeight) {
    Rng rng(SeedOf(FullTestName()));
    double worstX = 0, worstY = 0;
    for (int i = 0; i < 200000; ++i) {
        const SeenTriangle t(rng);
        const double whole = t.SolidAngle();
        if (whole < 1e-4 || whole > 6.2) continue;
        const Point2 u = rng.Uniform2D();
        const auto s = SphericalTriangle(t.from, t.a, t.b, t.c).Sample(u);
        ASSERT_TRUE(s);
        const double b1 = double(s->x), b2 = double(s->y), b0 = 1 - b1 - b2;
        const dvec3 x = (b0 * t.A() + b2 * t.C()) / (b0 + b2), w = b0 * t.A() + b1 * t.B() + b2 * t.C();
        const auto height = [&](dvec3 v) {
            const dvec3 d = glm::normalize(v) - glm::normalize(t.B());
            return glm::dot(d, d);
        };
        const double scale = t.Condition();
        const double ex = std::abs(SolidAngleInDoubles(t.A(), t.B(), x) / whole - double(u.x)) * (1 - b1);
        const double ey = std::abs(height(w) / height(x) - double(u.y));
        worstX = Worse(worstX, ex * scale);
        worstY = Worse(worstY, ey * scale);
    }
    EXPECT_LT(worstX, 2e-6);
    EXPECT_LT(worstY, 2e-5);
}

/// The integral of the direction over the triangle, half the sum of the angles of its sides times the normals
/// of their planes [Lambert 1760].
dvec3 VectorIrradiance(const std::array<dvec3, 3>& corners) {
    dvec3 sum(0);
    for (size_t i = 0; i < 3; ++i) {
        const dvec3 p = corners[i], q = corners[(i + 1) % 3], normal = glm::cross(p, q);
        sum += std::atan2(glm::length(normal), glm::dot(p, q)) / 2 * glm::normalize(normal);
    }
    return glm::dot(sum, corners[0]) < 0 ? -sum : sum;
}

/// The same by points on a grid of numbers, over the density; not a number if one of them fails.
dvec3 VectorIrradianceBySamples(Point3 from, const std::array<Point3, 3>& corners) {
    constexpr int kSide = 100;
    const SphericalTriangle seen(from, corners[0], corners[1], corners[2]);
    dvec3 sum(0);
    for (int i = 0; i < kSide * kSide; ++i) {
        const auto s = seen.Sample((Point2(i % kSide, i / kSide) + 0.5f) / float(kSide));
        if (!s) return dvec3(std::numeric_limits<double>::quiet_NaN());
        const double b1 = double(s->x), b2 = double(s->y);
        sum += glm::normalize((1 - b1 - b2) * dvec3(corners[0]) + b1 * dvec3(corners[1]) +
                              b2 * dvec3(corners[2]) - dvec3(from));
    }
    return sum * (double(seen.SolidAngle()) / (kSide * kSide));
}

// Under the rim of a lamp, a side spans nearly half of a circle: unit vectors to its ends cancel.
TEST(SphericalTriangle, NothingIsLostNextToItsSides) {
    const std::array<Point3, 3> triangle = {Point3(0, 0, 0), Point3(1, 0, 0), Point3(0.3f, 1, 0)};
    Rng rng(SeedOf(FullTestName()));
    double worst = 0;
    for (int trial = 0; trial < 300; ++trial) {
        // Which corner is the first must not matter.
        const auto first = size_t(trial % 3);
        const std::array<Point3, 3> corners = {triangle[first], triangle[(first + 1) % 3],
                                               triangle[(first + 2) % 3]};
        const float distance = std::pow(10.f, Lerp(rng.Uniform(), -6, -1)),
                    along = Lerp(rng.Uniform(), 0.1f, 0.9f);
        const Point3 onSide = triangle[0] + along * (triangle[1] - triangle[0]);
        // Straight below the side, below the triangle, or beside it.
        const float angle = Lerp(rng.Uniform(), 0.1f, Pi - 0.1f);
        const Point3 from = onSide + distance * Vec3(0, std::cos(angle), -std::sin(angle));
        const dvec3 o(from);
        const dvec3 expected =
            VectorIrradiance({dvec3(corners[0]) - o, dvec3(corners[1]) - o, dvec3(corners[2]) - o});
        worst = Worse(
            worst, glm::length(VectorIrradianceBySamples(from, corners) - expected) / glm::length(expected));
    }
    EXPECT_LT(worst, 3e-3);
}

TEST(SphericalTriangle, SolidAngleOfAnOctant) {
    EXPECT_NEAR(TriangleSolidAngle(Point3(0), {1, 0, 0}, {0, 2, 0}, {0, 0, 3}), double(PiOver2), 1e-6);
    EXPECT_NEAR(TriangleSolidAngle({0, 0, 1e-3f}, {-1e4f, -1e4f, 0}, {1e4f, -1e4f, 0}, {0, 2e4f, 0}),
                2 * double(Pi), 1e-3);
    EXPECT_EQ(TriangleSolidAngle({0.1f, 0.1f, 5}, {1, 1, 0}, {1, 1, 0}, {1, 1, 0}), 0);
}

// The fraction of the solid angle left of the first coordinate's point is that coordinate, by construction;
// checked against the solid angle of the part, which a different formula gives.
TEST(SphericalTriangle, FirstNumberIsAFractionOfTheSolidAngle) {
    const Point3 from(0.3f, -0.2f, 0.7f), a(-1, -1, 0), b(1, -1, 0.3f), c(0, 1, 0);
    const double whole = TriangleSolidAngle(from, a, b, c);
    for (int i = 1; i < 10; ++i) {
        // With the second number near 1 the point lies on the side a c.
        const auto s = SphericalTriangle(from, a, b, c).Sample({float(i) / 10, 1});
        ASSERT_TRUE(s);
        const Point3 p = (1 - s->x - s->y) * a + s->x * b + s->y * c;
        EXPECT_NEAR(s->x, 0, 1e-6f);
        EXPECT_NEAR(TriangleSolidAngle(from, a, b, p) / whole, double(i) / 10, 1e-5);
    }
}

TEST(SphericalRectangleSampling, SolidAngleIsThatOfTwoTriangles) {
    const Point3 corner(-1, 2, 0.5f);
    const Vec3 x(2, 0, 0), y(0, 1, 1);
    for (const Point3 from : {Point3(0, 0, 0), Point3(3, 4, 5), Point3(0, 2.5f, 1.2f), Point3(-20, 30, 10)}) {
        const double expected = TriangleSolidAngle(from, corner, corner + x, corner + y) +
                                TriangleSolidAngle(from, corner + x + y, corner + x, corner + y);
        EXPECT_NEAR(SphericalRectangle(from, corner, x, y).SolidAngle(), expected, 1e-6 * expected + 1e-12);
    }
}

TEST(SphericalRectangleSampling, FirstNumberIsAFractionOfTheSolidAngle) {
    const Point3 from(0.4f, 0.3f, 0.5f), corner(-1, -1, 0);
    const SphericalRectangle whole(from, corner, {2, 0, 0}, {0, 2, 0});
    for (int i = 1; i < 10; ++i) {
        const Vec2 s = whole.Sample({float(i) / 10, 0.5f});
        const SphericalRectangle left(from, corner, {2 * s.x, 0, 0}, {0, 2, 0});
        EXPECT_NEAR(left.SolidAngle() / whole.SolidAngle(), double(i) / 10, 1e-5);
    }
}

}  // namespace lacquer::test::spherical_sampling_test
