// What every shape promises about its points, checked in the same way for all of them.
#include <gtest/gtest.h>

#include "pbrt/core/rng.h"
#include "pbrt/core/sampling.h"
#include "shapes/shape_test_support.h"
#include "support/statistics.h"

namespace lacquer::test::shape_geometry_test {

namespace {

std::vector<ShapeSetup> Bases() {
    const std::vector<float> curved = {-1, -0.8f, -0.5f, 1, -0.8f, 0.5f, -1, 0.9f, 0.6f, 1, 0.9f, -0.6f};
    const std::vector<float> tetrahedron = {1, 1, 1, -1, -1, 1, -1, 1, -1, 1, -1, -1};
    return {
        {"sphere", {Floats("float", "radius", {1.5f})}},
        {"sphere",
         {Floats("float", "zmin", {-0.5f}), Floats("float", "zmax", {0.8f}),
          Floats("float", "phimax", {200})}},
        {"cylinder", {Floats("float", "radius", {0.7f}), Floats("float", "phimax", {280})}},
        {"disk",
         {Floats("float", "radius", {2}), Floats("float", "innerradius", {0.5f}),
          Floats("float", "height", {1})}},
        {"trianglemesh",
         {Floats("point3", "P", tetrahedron), Integers("indices", {0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2})}},
        {"trianglemesh",
         {Floats("point3", "P", tetrahedron), Integers("indices", {0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2}),
          Floats("point2", "uv", {0, 0, 0.3f, 1, 0.7f, 0.2f, 2, -1})}},
        {"bilinearmesh", {Floats("point3", "P", curved)}},
        {"bilinearmesh",
         {Floats("point3", "P", curved), Floats("point2", "uv", {0, 0, 2, 0.3f, 0.1f, 2, 2, 2})}},
        {"bilinearmesh", {Floats("point3", "P", {0, 0, 0, 1, 0, 0, 0.2f, 1, 0, 1.2f, 1, 0})}},
    };
}

std::vector<ShapeSetup> AllSetups() {
    std::vector<ShapeSetup> setups;
    for (const ShapeSetup& base : Bases())
        for (const Transform& transform :
             {Transform(), SomeRigidTransform(), SomeAffineTransform(), SomeMirroringTransform()})
            for (const bool reverse : {false, true}) {
                setups.push_back(base);
                setups.back().renderFromObject = transform;
                setups.back().reverseOrientation = reverse;
            }
    return setups;
}

// Rays from around the box to points in it.
Ray RandomRay(const Bounds3& box, Rng* rng) {
    const float size = Length(box.Diagonal());
    const Vec3 t(rng->Uniform(), rng->Uniform(), rng->Uniform());
    const Point3 o = box.Center() + size * (1 + rng->Uniform()) * SampleUniformSphere(rng->Uniform2D());
    const Point3 target = box.min + t * box.Diagonal();
    return {o, (target - o) * (0.5f + rng->Uniform()), 0.25f};
}

Bounds3 BoundsOf(const Shape& shape) {
    Bounds3 box;
    for (int i = 0; i < shape.NumPrimitives(); ++i) box = box.Union(shape.Bounds(i));
    return box;
}

}  // namespace

class ShapeGeometry : public testing::TestWithParam<int> {
  protected:
    ShapeGeometry()
        : setup_(AllSetups()[size_t(GetParam())]), shape_(MakeShape(setup_)), rng_(SeedOf(FullTestName())) {}

    // Calls check(ray, hit, primitive, interaction) for many hits.
    template <class Check>
    void ForHits(const Check& check) {
        const Bounds3 box = BoundsOf(*shape_);
        int hits = 0;
        for (int i = 0; i < 3000; ++i) {
            const Ray ray = RandomRay(box, &rng_);
            const NearestHit nearest = IntersectAll(*shape_, ray);
            if (nearest.primitive < 0) continue;
            ++hits;
            SurfaceInteraction si;
            shape_->Interaction(ray, nearest.hit, nearest.primitive, &si);
            check(ray, nearest, si);
            if (HasFailure()) return;
        }
        EXPECT_GT(hits, 300);
    }

    ShapeSetup setup_;
    std::unique_ptr<Shape> shape_;
    Rng rng_;
};

TEST_P(ShapeGeometry, HitsLieOnTheRayAndInTheBounds) {
    ForHits([&](const Ray& ray, const NearestHit& nearest, const SurfaceInteraction& si) {
        // t rounds to float; coordinates and reprojection to some units of the size.
        EXPECT_LT(Length(si.p - ray(nearest.hit.t)), 3e-6f * (Length(si.p) + nearest.hit.t * Length(ray.d)));
        Bounds3 box = shape_->Bounds(nearest.primitive);
        box.min -= Vec3(si.pError);
        box.max += Vec3(si.pError);
        EXPECT_TRUE(box.Contains(si.p));
        EXPECT_NEAR(Length(si.n), 1, 1e-5f);
        EXPECT_NEAR(Length(si.shading.n), 1, 1e-5f);
        EXPECT_EQ(si.time, ray.time);
        EXPECT_GT(si.pError, 0);
        EXPECT_LT(si.pError, 1e-5f * (Length(si.p) + Length(BoundsOf(*shape_).Diagonal())));
    });
}

TEST_P(ShapeGeometry, NormalIsAcrossTheTangents) {
    ForHits([&](const Ray&, const NearestHit&, const SurfaceInteraction& si) {
        EXPECT_NEAR(Dot(Normalize(si.dpdu), si.n), 0, 1e-5f);
        EXPECT_NEAR(Dot(Normalize(si.dpdv), si.n), 0, 1e-5f);
    });
}

// p and n of a neighbouring hit follow from the derivatives, with an error of second order in the distance.
TEST_P(ShapeGeometry, DerivativesPredictTheNeighbour) {
    int compared = 0;
    ForHits([&](const Ray& ray, const NearestHit& nearest, const SurfaceInteraction& si) {
        const float h = 2e-3f * Length(BoundsOf(*shape_).Diagonal());
        Vec3 x, y;
        CoordinateSystem(si.n, &x, &y);
        const float angle = 2 * Pi * rng_.Uniform();
        const Point3 target = si.p + h * (std::cos(angle) * x + std::sin(angle) * y);
        // A ray along the normal from close by meets the same sheet of the surface.
        const Ray probe{target + 5 * h * si.n, -si.n, ray.time};
        const auto hit = shape_->Intersect(probe, 0, 10 * h, nearest.primitive);
        if (!hit) return;
        SurfaceInteraction other;
        shape_->Interaction(probe, *hit, nearest.primitive, &other);
        const float du = other.uv.x - si.uv.x, dv = other.uv.y - si.uv.y;
        if (std::abs(du) > 0.3f || std::abs(dv) > 0.3f) return;  // across the seam, or near a pole
        ++compared;
        // Second derivatives grow toward poles and axes as 1 / |dpdu|; those are few, and the bound grows
        // with them.
        const float turn = std::max({std::abs(du), std::abs(dv), h});
        const float second =
            40 * turn * (Length(si.dpdu) * std::abs(du) + Length(si.dpdv) * std::abs(dv) + h);
        EXPECT_LT(Length(other.p - si.p - si.dpdu * du - si.dpdv * dv), second + 4e-6f * Length(si.p));
        const auto& s = si.shading;
        const float secondN =
            40 * turn * (Length(s.dndu) * std::abs(du) + Length(s.dndv) * std::abs(dv) + turn);
        EXPECT_LT(Length(other.shading.n - s.n - s.dndu * du - s.dndv * dv), secondN + 2e-5f);
    });
    EXPECT_GT(compared, 200);
}

TEST_P(ShapeGeometry, OnlyDerivativesOfNormalsAreLeftOutWhereNobodyWantsThem) {
    ForHits([&](const Ray& ray, const NearestHit& nearest, const SurfaceInteraction& si) {
        SurfaceInteraction without;
        without.wantsNormalDerivatives = false;
        without.shading.dndu = without.shading.dndv = Vec3(1);  // of a hit before
        shape_->Interaction(ray, nearest.hit, nearest.primitive, &without);
        EXPECT_EQ(without.p, si.p);
        EXPECT_EQ(without.pError, si.pError);
        EXPECT_EQ(without.n, si.n);
        EXPECT_EQ(without.uv, si.uv);
        EXPECT_EQ(without.dpdu, si.dpdu);
        EXPECT_EQ(without.dpdv, si.dpdv);
        EXPECT_EQ(without.faceIndex, si.faceIndex);
        EXPECT_EQ(without.shading.n, si.shading.n);
        EXPECT_EQ(without.shading.dpdu, si.shading.dpdu);
        EXPECT_EQ(without.shading.dpdv, si.shading.dpdv);
        EXPECT_EQ(without.shading.dndu, Vec3(0));
        EXPECT_EQ(without.shading.dndv, Vec3(0));
    });
}

TEST_P(ShapeGeometry, SamplesAreHitWithTheirNormalAndUv) {
    int compared = 0;
    for (int i = 0; i < 500; ++i) {
        const int primitive = int(rng_.UniformInt(uint32_t(shape_->NumPrimitives())));
        const auto sample = shape_->SampleArea(primitive, rng_.Uniform2D());
        ASSERT_TRUE(sample);
        const float size = Length(BoundsOf(*shape_).Diagonal()), h = 1e-2f * size;
        const Ray probe{sample->p + h * sample->n, -sample->n};
        const auto hit = shape_->Intersect(probe, 0, 2 * h, primitive);
        if (!hit) continue;  // at the very edge, or in a part that is trimmed away
        ++compared;
        SurfaceInteraction si;
        shape_->Interaction(probe, *hit, primitive, &si);
        EXPECT_LT(Length(si.p - sample->p), 1e-5f * (size + Length(si.p)));
        EXPECT_GT(Dot(si.n, sample->n), 0.9999f);
        if (std::abs(si.uv.x - sample->uv.x) < 0.5f) {
            EXPECT_NEAR(si.uv.x, sample->uv.x, 1e-3f);
            EXPECT_NEAR(si.uv.y, sample->uv.y, 1e-3f);
        }
    }
    EXPECT_GT(compared, 100);
}

// From convex shapes to their outer side, from flat ones to either; a saddle is met again only further away.
TEST_P(ShapeGeometry, RaysSpawnedFromTheSurfaceLeaveIt) {
    const bool convex = setup_.name == "sphere" || setup_.name == "cylinder";
    const Point3 center = setup_.renderFromObject.Point(Point3(0));
    const Vec3 axis = Normalize(setup_.renderFromObject.Vector(Vec3(0, 0, 1)));
    ForHits([&](const Ray&, const NearestHit& nearest, const SurfaceInteraction& si) {
        Vec3 w = SampleUniformSphere(rng_.Uniform2D());
        if (convex) {
            Vec3 outward = si.p - center;
            if (setup_.name == "cylinder") outward -= axis * Dot(axis, outward);
            w = FaceForward(w, FaceForward(si.n, outward));
        }
        const bool curved = setup_.name == "bilinearmesh";
        if (curved && AbsDot(w, si.n) < 0.1f) return;
        const Ray spawned{OffsetRayOrigin(si.p, si.pError, si.n, w), w};
        EXPECT_FALSE(shape_->Intersect(spawned, 0, curved ? 1e-3f : Infinity, nearest.primitive));
    });
}

INSTANTIATE_TEST_SUITE_P(All, ShapeGeometry, testing::Range(0, int(AllSetups().size())), [](const auto& row) {
    return AllSetups()[size_t(row.param)].name + std::to_string(row.param);
});

TEST(ShapeOrientation, QuadricsFlipUnderMirroringAndTrianglesDoNot) {
    const Transform mirror = Transform::Scale({-1, 1, 1});
    const Ray ray{{0, 0.1f, 5}, {0, 0, -1}};
    const auto normalOf = [&](const ShapeSetup& setup) {
        const auto shape = MakeShape(setup);
        const NearestHit nearest = IntersectAll(*shape, ray);
        SurfaceInteraction si;
        shape->Interaction(ray, nearest.hit, nearest.primitive, &si);
        return si.n.z;
    };
    EXPECT_GT(normalOf({"sphere", {}}), 0.9f);
    EXPECT_LT(normalOf({"sphere", {}, mirror}), -0.9f);
    EXPECT_LT(normalOf({"sphere", {}, Transform(), true}), -0.9f);
    EXPECT_GT(normalOf({"sphere", {}, mirror, true}), 0.9f);
    EXPECT_GT(normalOf({"disk", {}}), 0.9f);
    const Parameter triangle = Floats("point3", "P", {-1, -1, 0, 1, -1, 0, 0, 1, 0});
    EXPECT_GT(normalOf({"trianglemesh", {triangle}}), 0.9f);
    EXPECT_GT(normalOf({"trianglemesh", {triangle}, mirror}), 0.9f);
    EXPECT_LT(normalOf({"trianglemesh", {triangle}, mirror, true}), -0.9f);
    const Parameter patch = Floats("point3", "P", {-1, -1, 0, 1, -1, 0, -1, 1, 0, 1, 1, 0});
    EXPECT_GT(normalOf({"bilinearmesh", {patch}}), 0.9f);
    EXPECT_GT(normalOf({"bilinearmesh", {patch}, mirror}), 0.9f);
    EXPECT_LT(normalOf({"bilinearmesh", {patch}, Transform(), true}), -0.9f);
}

TEST(ShapeOrientation, VertexNormalsDecideAndOnlyReverseOrientationTurnsThem) {
    const Ray ray{{0, 0.1f, 5}, {0, 0, -1}};
    for (const bool patch : {false, true})
        for (const bool mirror : {false, true})
            for (const bool reverse : {false, true}) {
                ShapeSetup setup{patch ? "bilinearmesh" : "trianglemesh", {}};
                setup.parameters.push_back(Floats("point3", "P", {-1, -1, 0, 1, -1, 0, -1, 1, 0, 1, 1, 0}));
                if (!patch) setup.parameters.push_back(Integers("indices", {0, 1, 3, 0, 3, 2}));
                setup.parameters.push_back(
                    Floats("normal", "N", {0.2f, 0, -1, 0.2f, 0, -1, 0.2f, 0, -1, 0.2f, 0, -1}));
                if (mirror) setup.renderFromObject = Transform::Scale({-1, 1, 1});
                setup.reverseOrientation = reverse;
                const auto shape = MakeShape(setup);
                const NearestHit nearest = IntersectAll(*shape, ray);
                ASSERT_GE(nearest.primitive, 0);
                SurfaceInteraction si;
                shape->Interaction(ray, nearest.hit, nearest.primitive, &si);
                const float sign = reverse ? 1.f : -1.f, x = (mirror ? -0.2f : 0.2f) * (reverse ? -1.f : 1.f);
                EXPECT_NEAR(si.n.z, sign, 1e-6f);
                EXPECT_LT(Length(si.shading.n - Normalize(Vec3(x, 0, sign))), 1e-6f);
                EXPECT_NEAR(Dot(si.shading.dpdu, si.shading.n), 0, 1e-6f);
                EXPECT_GT(shape->SampleArea(nearest.primitive, {0.4f, 0.3f})->n.z * sign, 0.99f);
                EXPECT_GT(shape->NormalCone(nearest.primitive).first.z * sign, 0.99f);
            }
}

TEST(ShapeParameters, UvFollowsTheFormat) {
    const auto uvAt = [](const ShapeSetup& setup, const Ray& ray) {
        const auto shape = MakeShape(setup);
        const NearestHit nearest = IntersectAll(*shape, ray);
        EXPECT_GE(nearest.primitive, 0);
        SurfaceInteraction si;
        shape->Interaction(ray, nearest.hit, std::max(0, nearest.primitive), &si);
        return si.uv;
    };
    // Sphere: v = 0 at the bottom, u from +x toward +y.
    EXPECT_NEAR(uvAt({"sphere", {}}, {{0.01f, 0, -5}, {0, 0, 1}}).y, 0, 1e-2f);
    EXPECT_NEAR(uvAt({"sphere", {}}, {{0, 5, 0}, {0, -1, 0}}).x, 0.25f, 1e-5f);
    EXPECT_NEAR(uvAt({"sphere", {Floats("float", "phimax", {180})}}, {{0, 5, 0}, {0, -1, 0}}).x, 0.5f, 1e-5f);
    // Disk: v = 0 at the rim, 1 at the hole.
    const ShapeSetup disk{"disk", {Floats("float", "radius", {2}), Floats("float", "innerradius", {1})}};
    EXPECT_NEAR(uvAt(disk, {{1.9f, 0.001f, 1}, {0, 0, -1}}).y, 0.1f, 1e-4f);
    EXPECT_NEAR(uvAt(disk, {{1.1f, 0.001f, 1}, {0, 0, -1}}).y, 0.9f, 1e-4f);
    EXPECT_NEAR(uvAt({"cylinder", {}}, {{5, 0.001f, 0.5f}, {-1, 0, 0}}).y, 0.75f, 1e-5f);
    // Triangle: (0,0), (1,0), (1,1) by default.
    const ShapeSetup triangle{"trianglemesh", {Floats("point3", "P", {0, 0, 0, 1, 0, 0, 0, 1, 0})}};
    const Point2 uv = uvAt(triangle, {{0.25f, 0.5f, 1}, {0, 0, -1}});
    EXPECT_NEAR(uv.x, 0.75f, 1e-6f);
    EXPECT_NEAR(uv.y, 0.5f, 1e-6f);
    // Patch: the order p00, p10, p01, p11.
    const ShapeSetup patch{"bilinearmesh", {Floats("point3", "P", {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0})}};
    EXPECT_NEAR(uvAt(patch, {{0.25f, 0.75f, 1}, {0, 0, -1}}).x, 0.25f, 1e-6f);
    EXPECT_NEAR(uvAt(patch, {{0.25f, 0.75f, 1}, {0, 0, -1}}).y, 0.75f, 1e-6f);
}

TEST(ShapeParameters, TangentsSetTheShadingFrame) {
    const auto shape =
        MakeShape({"trianglemesh",
                   {Floats("point3", "P", {0, 0, 0, 1, 0, 0, 0, 1, 0}),
                    Floats("vector3", "S", {0, 1, 0, 0, 1, 0, 0, 1, 0}), Integers("faceIndices", {42})}});
    const Ray ray{{0.2f, 0.2f, 1}, {0, 0, -1}};
    SurfaceInteraction si;
    shape->Interaction(ray, *shape->Intersect(ray, 0, 10, 0), 0, &si);
    EXPECT_LT(Length(Normalize(si.shading.dpdu) - Vec3(0, 1, 0)), 1e-6f);
    EXPECT_EQ(si.faceIndex, 42);
}

/// A list of four vectors, times `length`.
std::vector<float> TimesFour(Vec3 v, float length) {
    std::vector<float> values;
    for (int i = 0; i < 4; ++i) values.insert(values.end(), {length * v.x, length * v.y, length * v.z});
    return values;
}

// Directions of any finite length: squares of 1e20 overflow, those of 1e-30 vanish.
TEST(ShapeParameters, NormalsAndTangentsMayHaveAnyLength) {
    const Vec3 n = Normalize({0.2f, -0.3f, 1}), s = Normalize({0.1f, 1, 0.2f});
    const Parameter square = Floats("point3", "P", {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0});
    const Ray ray{{0.2f, 0.3f, 1}, {0, 0, -1}};
    const auto frame = [&](const ShapeSetup& setup) {
        const auto shape = MakeShape(setup);
        SurfaceInteraction si;
        const NearestHit nearest = IntersectAll(*shape, ray);
        EXPECT_GE(nearest.primitive, 0);
        shape->Interaction(ray, nearest.hit, std::max(0, nearest.primitive), &si);
        return std::pair(si.shading.n, Normalize(si.shading.dpdu));
    };
    for (const float length : {1e-44f, 1e-30f, 1.f, 1e19f, 1e20f, 3e38f})
        for (const Transform& transform : {Transform(), Transform::Scale({1, 1, 1e-6f})}) {
            const float tolerance = length < 1e-38f ? 0.1f : 1e-5f;  // denormal numbers have few digits
            const Normal3 expected = Normalize(transform.Normal(n));
            const ShapeSetup triangles{
                "trianglemesh",
                {square, Floats("normal", "N", TimesFour(n, length)),
                 Floats("vector3", "S", TimesFour(s, length)), Integers("indices", {0, 1, 2, 1, 3, 2})},
                transform};
            const auto [normal, tangent] = frame(triangles);
            EXPECT_LT(Length(normal - expected), tolerance) << length;
            const Vec3 along = transform.Vector(s);
            EXPECT_LT(Length(tangent - Normalize(along - Dot(along, expected) * expected)), tolerance)
                << length;
            const ShapeSetup patch{
                "bilinearmesh", {square, Floats("normal", "N", TimesFour(n, length))}, transform};
            EXPECT_LT(Length(frame(patch).first - expected), tolerance) << length;
        }
    // The longest of a face's normals decide, as far as floats add them.
    std::vector<float> mixed = TimesFour(n, 1);
    for (int k = 0; k < 3; ++k) mixed[size_t(k)] = k == 0 ? -1e30f : 0;
    EXPECT_LT(
        Length(frame({"bilinearmesh", {square, Floats("normal", "N", mixed)}}).first - Normal3(-1, 0, 0)),
        1e-5f);
}

TEST(ShapeParameters, MistakesAreNamed) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const Parameter square = Floats("point3", "P", {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0});
    const std::vector<std::pair<ShapeSetup, std::string>> cases = {
        {{"sphere", {Floats("float", "radius", {0})}}, "\"radius\" is 0; a number above 0"},
        {{"sphere", {Floats("float", "radius", {-1})}}, "\"radius\" is -1"},
        {{"sphere", {Floats("float", "radius", {nan})}}, "nan"},
        {{"sphere", {Floats("float", "zmin", {2}), Floats("float", "zmax", {3})}}, "two different heights"},
        {{"sphere", {Floats("float", "phimax", {-5})}}, "(0, 360]"},
        {{"sphere", {Floats("float", "radius", {1e38f})}, Transform::Scale({9, 9, 9})},
         "too large for floats"},
        {{"cylinder", {Floats("float", "zmin", {1})}}, "two different heights"},
        {{"cylinder", {Floats("float", "radius", {Infinity})}}, "finite"},
        {{"disk", {Floats("float", "innerradius", {1})}}, "less than the radius, 1"},
        {{"disk", {Floats("float", "innerradius", {-0.5f})}}, "at least 0"},
        {{"trianglemesh", {}}, "\"point3 P\" is expected"},
        {{"trianglemesh", {square}}, "\"integer indices\" or exactly 3"},
        {{"trianglemesh", {square, Integers("indices", {0, 1, 2, 3})}}, "a multiple of 3"},
        {{"trianglemesh", {square, Integers("indices", {0, 1, 4})}},
         "element 2 of \"indices\" is 4; a vertex number in [0, 3]"},
        {{"trianglemesh", {square, Integers("indices", {0, -1, 2})}}, "is -1"},
        {{"trianglemesh", {square, Integers("indices", {0, 1, 2000000000})}}, "is 2000000000"},
        {{"trianglemesh", {square, Integers("indices", {0, 1, 2}), Floats("point2", "uv", {0, 0})}},
         "\"uv\" has 1 elements"},
        {{"trianglemesh", {square, Integers("indices", {0, 1, 2}), Floats("normal", "N", {0, 0, 1})}},
         "\"N\" has 1 elements"},
        {{"trianglemesh", {square, Integers("indices", {0, 1, 2}), Floats("vector3", "S", {0, 0, 1})}},
         "\"S\" has 1 elements"},
        {{"trianglemesh", {square, Integers("indices", {0, 1, 2}), Integers("faceIndices", {1, 2})}},
         "each of the 1 faces"},
        {{"trianglemesh", {Floats("point3", "P", {0, 0, nan, 1, 0, 0, 0, 1, 0})}}, "finite"},
        {{"trianglemesh",
          {Floats("point3", "P", {0, 0, 3e38f, 1, 0, 0, 0, 1, 0})},
          Transform::Scale({9, 9, 9})},
         "too large"},
        {{"bilinearmesh", {square, Integers("indices", {0, 1, 2})}}, "a multiple of 4"},
        {{"plymesh", {}}, "\"string filename\" is expected"},
    };
    for (const auto& [setup, expected] : cases) {
        const std::string error = ErrorOf(setup);
        EXPECT_NE(error.find(expected), std::string::npos)
            << setup.name << ": " << error << "\nexpected: " << expected;
        EXPECT_EQ(error.find("test.pbrt:7:"), 0u) << error;
    }
}

TEST(Interaction, UvFootprintSolvesTheTangentPlane) {
    SurfaceInteraction si;
    si.dpdu = {2, 0, 0.5f};
    si.dpdv = {0.3f, 1, 0};
    si.dpdx =
        0.1f * si.dpdu - 0.2f * si.dpdv + Cross(si.dpdu, si.dpdv);  // what leaves the plane does not count
    si.dpdy = 3.f * si.dpdu;
    si.ComputeUvFootprint();
    EXPECT_NEAR(si.dudx, 0.1f, 1e-6f);
    EXPECT_NEAR(si.dvdx, -0.2f, 1e-6f);
    EXPECT_NEAR(si.dudy, 3, 1e-5f);
    EXPECT_NEAR(si.dvdy, 0, 1e-5f);
    si.dpdv = si.dpdu;
    si.ComputeUvFootprint();
    EXPECT_EQ(si.dudx, 0);
    si.dpdu = {1e-30f, 0, 0};
    si.dpdv = {0, 1e-30f, 0};
    si.ComputeUvFootprint();
    EXPECT_TRUE(std::isfinite(si.dudx) && std::isfinite(si.dvdy));
}

}  // namespace lacquer::test::shape_geometry_test
