// Curves: the basis changes, where rays meet them, and what they are there.
#include <gtest/gtest.h>

#include "pbrt/core/rng.h"
#include "pbrt/core/sampling.h"
#include "pbrt/shapes/curve_segment.h"
#include "shapes/shape_test_support.h"
#include "support/statistics.h"

namespace lacquer::test::curve_test {
namespace {

/// Four random control points in the cube [-1, 1]^3.
std::vector<float> RandomValues(Rng& rng, int count) {
    std::vector<float> values;
    for (int i = 0; i < count; ++i) values.push_back(2 * rng.Uniform() - 1);
    return values;
}
std::vector<Point3> ToPoints(const std::vector<float>& values) {
    std::vector<Point3> points;
    for (size_t i = 0; i + 2 < values.size(); i += 3)
        points.push_back({values[i], values[i + 1], values[i + 2]});
    return points;
}
Point3 BezierAt(std::vector<Point3> p, float u) {
    while (p.size() > 1) {
        for (size_t i = 0; i + 1 < p.size(); ++i) p[i] = (1 - u) * p[i] + u * p[i + 1];
        p.pop_back();
    }
    return p[0];
}
/// Uniform B-spline on [degree + i, degree + i + 1] by the recursion of de Boor.
Point3 BSplineAt(const std::vector<Point3>& p, int degree, float x) {
    const int knot = std::min(int(x), int(p.size()) - 1);
    std::vector<Point3> d(p.begin() + (knot - degree), p.begin() + (knot + 1));
    for (int r = 1; r <= degree; ++r)
        for (int j = degree; j >= r; --j) {
            const float a = (x - float(j + knot - degree)) / float(degree + 1 - r);
            d[size_t(j)] = (1 - a) * d[size_t(j - 1)] + a * d[size_t(j)];
        }
    return d[size_t(degree)];
}
BezierPoints PointsOf(const std::vector<Point3>& p, size_t first = 0) {
    BezierPoints b;
    for (int i = 0; i < 4; ++i) {
        b.x[i] = p[first + size_t(i)].x;
        b.y[i] = p[first + size_t(i)].y;
        b.z[i] = p[first + size_t(i)].z;
    }
    return b;
}
SurfaceInteraction Interact(const Shape& shape, const Ray& ray, const NearestHit& nearest) {
    SurfaceInteraction si;
    shape.Interaction(ray, nearest.hit, nearest.primitive, &si);
    return si;
}
/// A straight fibre from (0, 0, 0) to (0, 1, 0).
ShapeSetup Straight(const std::string& type, std::vector<Parameter> more = {}) {
    ShapeSetup setup{"curve",
                     {Floats("point3", "P", {0, 0, 0, 0, 1 / 3.f, 0, 0, 2 / 3.f, 0, 0, 1, 0}),
                      Strings("string", "type", {type})}};
    for (Parameter& parameter : more) setup.parameters.push_back(std::move(parameter));
    return setup;
}
const Vec3 kAway(0, 0, -1);

TEST(CurveBasis, BezierSegmentsFollowTheControlPoints) {
    Rng rng(SeedOf(FullTestName()));
    for (const int degree : {2, 3}) {
        const std::vector<Point3> p = ToPoints(RandomValues(rng, 3 * (3 * degree + 1)));
        const std::vector<Point3> cubic = ToCubicBezier(p, degree, false);
        ASSERT_EQ(cubic.size(), 10u);
        for (int segment = 0; segment < 3; ++segment)
            for (float u = 0; u <= 1; u += 0.125f) {
                const auto first = p.begin() + segment * degree;
                const Point3 expected = BezierAt({first, first + degree + 1}, u);
                EXPECT_LT(Length(PointsOf(cubic, size_t(3 * segment)).At(u) - expected), 1e-6f);
            }
    }
}

TEST(CurveBasis, BSplinesFollowDeBoor) {
    Rng rng(SeedOf(FullTestName()));
    for (const int degree : {2, 3}) {
        const std::vector<Point3> p = ToPoints(RandomValues(rng, 3 * (degree + 4)));
        const std::vector<Point3> cubic = ToCubicBezier(p, degree, true);
        ASSERT_EQ(cubic.size(), 13u);
        for (int segment = 0; segment < 4; ++segment)
            for (float u = 0; u < 1; u += 0.125f)
                EXPECT_LT(Length(PointsOf(cubic, size_t(3 * segment)).At(u) -
                                 BSplineAt(p, degree, float(degree + segment) + u)),
                          2e-6f);
    }
}

TEST(CurveParts, AreThePiecesOfTheCurveAndShareTheirEnds) {
    Rng rng(SeedOf(FullTestName()));
    const BezierPoints whole = PointsOf(ToPoints(RandomValues(rng, 12)));
    for (int log2 = 0; log2 <= kMaxLog2CurveParts; ++log2)
        for (int part = 0; part < 1 << log2; ++part) {
            const BezierPoints piece = PartOf(whole, log2, part);
            for (float s = 0; s <= 1; s += 0.25f)
                EXPECT_LT(Length(piece.At(s) - whole.At((float(part) + s) / float(1 << log2))), 1e-6f);
            if (part > 0) {
                EXPECT_EQ(PartOf(whole, log2, part - 1)[3], piece[0]);
            }
        }
}

TEST(Curve, IsAsWideAsItSaysAndCutOffSquare) {
    const auto shape =
        MakeShape(Straight("flat", {Floats("float", "width0", {0.4f}), Floats("float", "width1", {0.2f})}));
    const auto hits = [&](float x, float y) {
        return IntersectAll(*shape, {{x, y, 2}, 2.f * kAway}).primitive >= 0;
    };
    for (const float y : {0.01f, 0.5f, 0.99f}) {
        const float half = 0.5f * Lerp(y, 0.4f, 0.2f);
        for (const float sign : {-1.f, 1.f}) {
            EXPECT_TRUE(hits(sign * (half - 1e-4f), y)) << y;
            EXPECT_FALSE(hits(sign * (half + 1e-4f), y)) << y;
        }
    }
    for (const float x : {0.f, 0.09f}) {
        EXPECT_FALSE(hits(x, -1e-3f));
        EXPECT_FALSE(hits(x, 1 + 1e-3f));
    }
    // The interval of t is open, in units of the direction's length.
    const Ray ray{{0.05f, 0.5f, 2}, 2.f * kAway};
    EXPECT_FLOAT_EQ(IntersectAll(*shape, ray).hit.t, 1);
    EXPECT_LT(IntersectAll(*shape, ray, 0, 0.999f).primitive, 0);
    EXPECT_LT(IntersectAll(*shape, ray, 1.001f, 5).primitive, 0);
}

TEST(Curve, FacesTheRay) {
    const auto shape = MakeShape(Straight("flat", {Floats("float", "width", {0.2f})}));
    const Ray ray{{0.05f, 0.3f, 2}, kAway};
    const NearestHit nearest = IntersectAll(*shape, ray);
    const SurfaceInteraction si = Interact(*shape, ray, nearest);
    EXPECT_LT(Length(si.p - Point3(0.05f, 0.3f, 0)), 1e-6f);
    EXPECT_NEAR(si.uv.x, 0.3f, 1e-6f);
    // v grows along d x dpdu = +x; the normal, dpdu x dpdv, points along the ray.
    EXPECT_NEAR(si.uv.y, 0.75f, 1e-6f);
    EXPECT_LT(Length(si.dpdu - Vec3(0, 1, 0)), 1e-6f);
    EXPECT_LT(Length(si.dpdv - Vec3(0.2f, 0, 0)), 1e-6f);
    EXPECT_LT(Length(si.n - kAway), 1e-6f);
    EXPECT_GE(si.pError, 0.2f);
    EXPECT_LT(si.pError, 0.2001f);
}

TEST(Curve, ACylinderTurnsItsNormalByHalfATurnFromEdgeToEdge) {
    const auto shape = MakeShape(Straight("cylinder", {Floats("float", "width", {0.2f})}));
    for (const float v : {0.02f, 0.25f, 0.5f, 0.8f}) {
        const Ray ray{{0.2f * (v - 0.5f), 0.3f, 2}, kAway};
        const SurfaceInteraction si = Interact(*shape, ray, IntersectAll(*shape, ray));
        const float theta = PiOver2 * (2 * v - 1);
        EXPECT_NEAR(si.uv.y, v, 1e-5f);
        EXPECT_LT(Length(si.n - Vec3(std::sin(theta), 0, -std::cos(theta))), 1e-4f);
        EXPECT_NEAR(Length(si.dpdv), 0.2f, 1e-5f);
        EXPECT_NEAR(Dot(si.dpdu, si.dpdv), 0, 1e-6f);
    }
}

TEST(Curve, ARibbonFollowsItsNormals) {
    // From facing the ray to edge-on: the normal turns evenly, and so the width narrows as a cosine.
    const auto shape = MakeShape(
        Straight("ribbon", {Floats("float", "width", {0.2f}), Floats("normal", "N", {0, 0, 3, 1, 0, 0})}));
    for (const float y : {0.1f, 0.5f, 0.9f}) {
        const float angle = PiOver2 * y, half = 0.1f * std::cos(angle);
        const Ray inside{{half - 1e-4f, y, 2}, kAway}, outside{{half + 1e-4f, y, 2}, kAway};
        const NearestHit nearest = IntersectAll(*shape, inside);
        ASSERT_GE(nearest.primitive, 0) << y;
        EXPECT_LT(IntersectAll(*shape, outside).primitive, 0) << y;
        const SurfaceInteraction si = Interact(*shape, inside, nearest);
        EXPECT_LT(Length(si.n - Vec3(std::sin(angle), 0, std::cos(angle))), 1e-4f);
    }
}

TEST(Curve, URestartsInEverySegmentAndTheWidthDoesNot) {
    std::vector<float> p;
    for (int i = 0; i < 7; ++i) p.insert(p.end(), {0, float(i) / 3, 0});
    const auto shape = MakeShape({"curve",
                                  {Floats("point3", "P", p), Floats("float", "width0", {0.4f}),
                                   Floats("float", "width1", {0.2f}), Integers("splitdepth", {1})}});
    for (const float y : {0.25f, 0.75f, 1.25f, 1.75f}) {
        const float half = 0.5f * Lerp(y / 2, 0.4f, 0.2f);
        const Ray ray{{half - 1e-3f, y, 2}, kAway};
        const NearestHit nearest = IntersectAll(*shape, ray);
        ASSERT_GE(nearest.primitive, 0);
        EXPECT_NEAR(Interact(*shape, ray, nearest).uv.x, y - std::floor(y), 1e-5f);
        EXPECT_LT(IntersectAll(*shape, {{half + 1e-3f, y, 2}, kAway}).primitive, 0);
    }
}

/// Squared distance of the ray's line from the curve, relative to half the width there, where it is least: by
/// trying many points. Also the parameter and the distance along the ray. Ends count where the curve leaves
/// the ray square to it only.
struct Approach {
    float ratio = Infinity, u = 0, t = 0;
};
std::vector<Approach> ApproachesOf(const BezierPoints& p, const Ray& ray, float width0, float width1) {
    constexpr int kSteps = 4000;
    std::vector<Approach> approaches;
    const auto at = [&](int i) {
        const float u = float(i) / kSteps;
        const Vec3 offset = p.At(u) - ray.o;
        const float t = Dot(offset, ray.d);
        return Approach{Length(offset - t * ray.d) / (0.5f * Lerp(u, width0, width1)), u, t};
    };
    Approach before = at(0), current = at(1);
    for (int i = 2; i <= kSteps; ++i) {
        const Approach next = at(i);
        if (current.ratio <= before.ratio && current.ratio < next.ratio) approaches.push_back(current);
        before = current;
        current = next;
    }
    return approaches;
}

TEST(Curve, HitsAreWhereTheCurveIsNearTheRay) {
    Rng rng(SeedOf(FullTestName()));
    int hits = 0, misses = 0;
    for (int c = 0; c < 20; ++c) {
        const std::vector<float> values = RandomValues(rng, 12);
        const float width0 = 0.02f + 0.05f * rng.Uniform(), width1 = width0;
        const auto shape = MakeShape({"curve",
                                      {Floats("point3", "P", values), Floats("float", "width0", {width0}),
                                       Floats("float", "width1", {width1})}});
        const BezierPoints p = PointsOf(ToPoints(values));
        for (int i = 0; i < 30; ++i) {
            // At a point near the curve, not within half a width of the ends.
            const float u = 0.1f + 0.8f * rng.Uniform();
            const Point3 target = p.At(u) + width0 * SampleUniformSphere(rng.Uniform2D());
            const Point3 o = 4.f * SampleUniformSphere(rng.Uniform2D());
            const Ray ray{o, Normalize(target - o)};
            // The curve as seen along the ray must be smooth at the scale of the width.
            const Vec3 du = p.DerivativeAt(u);
            if (Length(Cross(du, ray.d)) < 0.3f * Length(du)) continue;
            const NearestHit nearest = IntersectAll(*shape, ray);
            Approach best;
            bool uncertain = false;
            for (const Approach& a : ApproachesOf(p, ray, width0, width1)) {
                uncertain |= std::abs(a.ratio - 1) < 0.02f || a.u < 0.02f || a.u > 0.98f;
                if (a.ratio < 1 && (best.ratio == Infinity || a.t < best.t)) best = a;
            }
            if (uncertain) continue;
            ASSERT_EQ(nearest.primitive >= 0, best.ratio < 1) << c << " " << i;
            ++(best.ratio < 1 ? hits : misses);
            if (nearest.primitive < 0) continue;
            EXPECT_NEAR(nearest.hit.t, best.t, 2e-3f);
            EXPECT_NEAR(std::abs(nearest.hit.coordinates.y - 0.5f), 0.5f * best.ratio, 5e-3f);
        }
    }
    EXPECT_GT(hits, 100);
    EXPECT_GT(misses, 20);
}

std::vector<ShapeSetup> AllTypes(Rng& rng) {
    std::vector<ShapeSetup> setups;
    for (const char* type : {"flat", "cylinder", "ribbon"})
        for (const Transform& t :
             {Transform(), SomeRigidTransform(), SomeRigidTransform() * Transform::Scale(Vec3(3)),
              SomeAffineTransform(), SomeMirroringTransform()}) {
            ShapeSetup setup{"curve",
                             {Floats("point3", "P", RandomValues(rng, 21)), Strings("string", "type", {type}),
                              Floats("float", "width0", {0.1f}), Floats("float", "width1", {0.02f})},
                             t};
            if (std::string(type) == "ribbon")
                setup.parameters.push_back(Floats("normal", "N", RandomValues(rng, 9)));
            setups.push_back(setup);
        }
    return setups;
}
Ray RandomRay(Rng& rng, const Transform& t) {
    const Point3 o = 3.f * SampleUniformSphere(rng.Uniform2D());
    const Point3 target = 0.7f * SampleUniformSphere(rng.Uniform2D());
    const Ray local{o, target - o};
    return t.Ray(local);
}

TEST(Curve, HitsLieInTheirBoxesWithPerpendicularFrames) {
    Rng rng(SeedOf(FullTestName()));
    for (const ShapeSetup& setup : AllTypes(rng)) {
        const auto shape = MakeShape(setup);
        int hits = 0;
        for (int i = 0; i < 3000; ++i) {
            const Ray ray = RandomRay(rng, setup.renderFromObject);
            const NearestHit nearest = IntersectAll(*shape, ray);
            if (nearest.primitive < 0) continue;
            ++hits;
            const SurfaceInteraction si = Interact(*shape, ray, nearest);
            EXPECT_TRUE(shape->Bounds(nearest.primitive).Contains(si.p));
            EXPECT_NEAR(Length(si.n), 1, 1e-5f);
            EXPECT_NEAR(Dot(Normalize(si.dpdu), si.n), 0, 1e-4f);
            EXPECT_NEAR(Dot(Normalize(si.dpdv), si.n), 0, 1e-4f);
            EXPECT_TRUE(si.uv.x >= 0 && si.uv.x <= 1 && si.uv.y >= 0 && si.uv.y <= 1);
        }
        EXPECT_GT(hits, 50);
    }
}

// A curve in rendering space, or with its rays taken to object space, is the same thing as the curve without
// a transform, met by the transformed ray.
TEST(Curve, TransformsMeanWhatTheyMean) {
    Rng rng(SeedOf(FullTestName()));
    for (ShapeSetup setup : AllTypes(rng)) {
        const Transform t = setup.renderFromObject;
        const auto placed = MakeShape(setup);
        setup.renderFromObject = Transform();
        const auto still = MakeShape(setup);
        int hits = 0, disagreements = 0;
        for (int i = 0; i < 2000; ++i) {
            const Ray local = RandomRay(rng, Transform()), ray = t.Ray(local);
            const NearestHit a = IntersectAll(*still, local), b = IntersectAll(*placed, ray);
            if ((a.primitive < 0) != (b.primitive < 0)) {
                ++disagreements;
                continue;
            }
            if (a.primitive < 0) continue;
            ++hits;
            if (std::abs(a.hit.t - b.hit.t) > 1e-3f) {
                ++disagreements;
                continue;
            }
            const SurfaceInteraction s = Interact(*still, local, a), p = Interact(*placed, ray, b);
            EXPECT_LT(Length(t.Point(s.p) - p.p), 1e-4f);
            if (std::abs(s.uv.x - p.uv.x) > 1e-3f) continue;  // two ways to be near, at a sharp bend
            EXPECT_NEAR(s.uv.y, p.uv.y, 1e-2f);
            EXPECT_LT(Length(t.Vector(s.dpdv) - p.dpdv), 2e-2f * Length(p.dpdv));
            // The mirroring turns the normal around, as those of all quadrics.
            const float sign = t.SwapsHandedness() ? -1.f : 1.f;
            EXPECT_GT(sign * Dot(Normalize(t.Normal(s.n)), p.n), 0.999f);
        }
        EXPECT_GT(hits, 30);
        EXPECT_LE(disagreements, 1 + hits / 50);
    }
}

TEST(Curve, RaysThatLeaveItDoNotMeetItAgain) {
    Rng rng(SeedOf(FullTestName()));
    const auto shape = MakeShape(Straight("flat", {Floats("float", "width", {0.05f})}));
    for (int i = 0; i < 500; ++i) {
        const Ray ray{{0.04f * (rng.Uniform() - 0.5f), 0.2f + 0.6f * rng.Uniform(), 2}, kAway};
        const NearestHit nearest = IntersectAll(*shape, ray);
        ASSERT_GE(nearest.primitive, 0);
        const SurfaceInteraction si = Interact(*shape, ray, nearest);
        const Vec3 w = SampleUniformSphere(rng.Uniform2D());
        const Ray next{OffsetRayOrigin(si.p, si.pError, si.n, w), w};
        EXPECT_LT(IntersectAll(*shape, next).primitive, 0);
    }
}

TEST(Curve, CoincidingControlPointsAreNoTrouble) {
    // Tangents vanish at the ends, or everywhere: nothing is hit that is not there, and all is finite.
    for (const std::vector<float>& p : {std::vector<float>{0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0},
                                        std::vector<float>{0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0}}) {
        const auto shape = MakeShape({"curve", {Floats("point3", "P", p), Floats("float", "width", {0.1f})}});
        Rng rng(SeedOf(FullTestName()));
        for (int i = 0; i < 500; ++i) {
            const Ray ray{{0.2f * (rng.Uniform() - 0.5f), 1.4f * rng.Uniform() - 0.2f, 2}, kAway};
            const NearestHit nearest = IntersectAll(*shape, ray);
            if (nearest.primitive < 0) continue;
            EXPECT_TRUE(ray.o.y > -1e-3f && ray.o.y < 1 + 1e-3f);
            const SurfaceInteraction si = Interact(*shape, ray, nearest);
            EXPECT_TRUE(IsFinite(si.n) && IsFinite(si.dpdu) && IsFinite(si.dpdv));
        }
    }
    // Along the fibre there is nothing to see.
    const auto straight = MakeShape(Straight("flat"));
    EXPECT_LT(IntersectAll(*straight, {{0, -1, 0}, {0, 1, 0}}).primitive, 0);
}

TEST(CurveParameters, NormalsMayHaveAnyLength) {
    const Parameter line = Floats("point3", "P", {0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0});
    for (const float length : {1e-30f, 1.f, 1e20f, 3e38f}) {
        const auto shape = MakeShape({"curve",
                                      {line, Strings("string", "type", {"ribbon"}),
                                       Floats("normal", "N", {0, 0, length, 0, 0, length})}});
        const Ray ray{{1, 0.1f, 5}, {0, 0, -1}};
        const NearestHit nearest = IntersectAll(*shape, ray);
        ASSERT_GE(nearest.primitive, 0) << length;
        SurfaceInteraction si;
        shape->Interaction(ray, nearest.hit, nearest.primitive, &si);
        EXPECT_NEAR(std::abs(si.n.z), 1, 1e-5f) << length;
    }
}

TEST(CurveParameters, MistakesAreNamed) {
    const Parameter four = Floats("point3", "P", {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0});
    const std::vector<float> fiveValues = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 2, 2, 2};
    const Parameter five = Floats("point3", "P", fiveValues);
    const Parameter ribbon = Strings("string", "type", {"ribbon"}),
                    bspline = Strings("string", "basis", {"bspline"});
    const std::vector<std::pair<ShapeSetup, std::string>> cases = {
        {{"curve", {}}, "\"point3 P\" is expected"},
        {{"curve", {five}}, "5 points; a Bezier curve of degree 3 has 4, 7, 10"},
        {{"curve", {four, Integers("degree", {2})}}, "4 points; a Bezier curve of degree 2 has 3, 5, 7"},
        {{"curve", {Floats("point3", "P", {0, 0, 0, 1, 0, 0, 1, 1, 0}), bspline}},
         "3 points; a B-spline of degree 3 has at least 4"},
        {{"curve", {four, Integers("degree", {4})}}, "\"integer degree\" must lie in [2, 3], is 4"},
        {{"curve", {four, Strings("string", "basis", {"bsplin"})}}, "bspline"},
        {{"curve", {four, Strings("string", "type", {"cylindre"})}}, "cylinder"},
        {{"curve", {four, Floats("float", "width0", {-1})}}, "\"width0\" is -1; a width of at least 0"},
        {{"curve", {four, ribbon}}, "0 normals; a ribbon of 1 segments has 2"},
        {{"curve", {four, ribbon, Floats("normal", "N", {0, 0, 1, 0, 0, 1, 0, 0, 1})}}, "3 normals"},
        {{"curve", {four, ribbon, Floats("normal", "N", {0, 0, 1, 0, 0, 0})}}, "element 1 of \"N\""},
        {{"curve", {Floats("point3", "P", {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1e30f, 0})}}, "too large"},
        {{"curve", {four, Floats("float", "width", {1e30f})}}, "too large"},
    };
    for (const auto& [setup, expected] : cases) {
        const std::string error = ErrorOf(setup);
        EXPECT_NE(error.find(expected), std::string::npos) << error << "\nexpected: " << expected;
    }
    EXPECT_EQ(ErrorOf({"curve", {five, bspline, Integers("splitdepth", {3})}}), "");
    EXPECT_EQ(MakeShape({"curve", {four}})->WhyNoEmitter(), "a curve cannot be an area light");
}

}  // namespace
}  // namespace lacquer::test::curve_test
