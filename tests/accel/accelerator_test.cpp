#include "pbrt/accel/accelerator.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "pbrt/accel/few_boxes.h"
#include "pbrt/base/constant_texture.h"
#include "pbrt/core/rng.h"
#include "shapes/shape_test_support.h"
#include "support/statistics.h"

namespace lacquer::accelerator_test {
namespace {

using test::Floats;
using test::FullTestName;
using test::Integers;
using test::Outcome;
using test::Passes;
using test::RunningMean;
using test::SeedOf;

Vec3 RandomVector(Rng& rng, float extent = 1) {
    return extent * (2.f * Vec3(rng.Uniform(), rng.Uniform(), rng.Uniform()) - 1.f);
}
/// Within the cube [-4, 4]^3 or so, of any orientation, stretched by up to 2, perhaps mirrored.
Transform RandomPlacement(Rng& rng) {
    const Vec3 scale(1 + rng.Uniform(), 0.5f + rng.Uniform(), rng.Uniform() < 0.3f ? -1.f : 1.f);
    return Transform::Translate(RandomVector(rng, 3)) *
           Transform::Rotate(360 * rng.Uniform(), RandomVector(rng)) * Transform::Scale(scale);
}

std::vector<float> RandomPoints(Rng& rng, int count) {
    std::vector<float> values;
    for (int i = 0; i < 3 * count; ++i) values.push_back(2 * rng.Uniform() - 1);
    return values;
}

/// Shape number `i` in turn of each kind.
std::unique_ptr<Shape> RandomShape(Rng& rng, int i) {
    const Transform t = RandomPlacement(rng);
    switch (i % 6) {
        case 0: {
            std::vector<int> indices;
            for (int k = 0; k < 60; ++k) indices.push_back(int(rng.UniformInt(30)));
            return test::MakeShape(
                {"trianglemesh",
                 {Floats("point3", "P", RandomPoints(rng, 30)), Integers("indices", indices)},
                 t});
        }
        case 1:
            return test::MakeShape(
                {"bilinearmesh",
                 {Floats("point3", "P", RandomPoints(rng, 8)), Integers("indices", {0, 1, 2, 3, 4, 5, 6, 7})},
                 t});
        case 2:
            return test::MakeShape(
                {"sphere",
                 {Floats("float", "radius", {0.3f + rng.Uniform()}), Floats("float", "zmax", {0.4f}),
                  Floats("float", "phimax", {90 + 270 * rng.Uniform()})},
                 t});
        case 3:
            return test::MakeShape(
                {"disk",
                 {Floats("float", "radius", {1.2f}), Floats("float", "innerradius", {0.3f}),
                  Floats("float", "phimax", {300})},
                 t});
        case 4:
            return test::MakeShape({"curve",
                                    {Floats("point3", "P", RandomPoints(rng, 7)),
                                     Floats("float", "width0", {0.5f}), Floats("float", "width1", {0.2f})},
                                    t});
        default:
            return test::MakeShape({"cylinder",
                                    {Floats("float", "radius", {0.6f}), Floats("float", "zmin", {-0.5f}),
                                     Floats("float", "zmax", {1})},
                                    t});
    }
}

/// Shapes in the world and in two objects, which still, mirrored and moving instances place.
struct TestScene {
    std::vector<std::unique_ptr<Shape>> shapes;
    std::vector<std::vector<AccelGeometry>> groups;
    std::vector<AccelInstance> instances;

    /// @param numInWorld  shapes that stand there by themselves; so many instances move, and half as many are
    ///                    still
    TestScene(Rng& rng, int numInWorld) {
        groups.resize(3);
        for (size_t group = 0; group < 3; ++group)
            for (int i = 0; i < (group == 0 ? numInWorld : 6); ++i) {
                shapes.push_back(RandomShape(rng, i));
                groups[group].push_back({shapes.back().get(), nullptr});
            }
        for (int i = 0; i < numInWorld / 2 * 3; ++i) {
            const Transform start = RandomPlacement(rng) * Transform::Scale(Vec3(0.5f));
            const Transform end = Transform::Translate(RandomVector(rng, 2)) * start *
                                  Transform::Rotate(100 * rng.Uniform(), RandomVector(rng));
            instances.push_back(
                {1 + i % 2, i % 3 == 0 ? AnimatedTransform(start) : AnimatedTransform(start, 0, end, 1)});
        }
    }

    /// Nearest hit with t < tMax by trying everything.
    float BruteForce(const Ray& ray, float tMax) const {
        for (const AccelGeometry& g : groups[0]) Try(*g.shape, ray, &tMax);
        for (const AccelInstance& instance : instances) {
            const Ray local = instance.renderFromObject.At(ray.time).InverseRay(ray);
            for (const AccelGeometry& g : groups[size_t(instance.group)]) Try(*g.shape, local, &tMax);
        }
        return tMax;
    }
    /// Distance at which the primitive that `hit` names is met, or infinity.
    float Distance(const Ray& ray, const Hit& hit) const {
        const Ray local = hit.instance < 0
                              ? ray
                              : instances[size_t(hit.instance)].renderFromObject.At(ray.time).InverseRay(ray);
        const Shape& shape = *groups[size_t(hit.group)][size_t(hit.geometry)].shape;
        const auto found = shape.Intersect(local, 0, Infinity, hit.primitive);
        return found ? found->t : Infinity;
    }

  private:
    static void Try(const Shape& shape, const Ray& ray, float* tMax) {
        const test::NearestHit nearest = test::IntersectAll(shape, ray, 0, *tMax);
        if (nearest.primitive >= 0) *tMax = nearest.hit.t;
    }
};

/// One mesh and four primitives of other kinds, and moving instances, each few enough for boxes side by side;
/// and too many for them.
constexpr int kFew = 4, kMany = 12;
static_assert(kFew <= FewBoxes::kMax && kMany > FewBoxes::kMax);

Ray RandomRay(Rng& rng) {
    const Point3 o = RandomVector(rng, 6);
    return {o, Normalize(RandomVector(rng, 3) - o), rng.Uniform()};
}
// Two float intersections of one surface differ by a few roundings of coordinates up to 15, more at grazing
// angles.
bool Near(float a, float b) { return a == b || std::abs(a - b) <= 2e-3f; }

TEST(Accelerator, AgreesWithBruteForce) {
    // Rays within about 1e-6 of an edge may differ: none to two of 30,000.
    Rng rng(SeedOf(FullTestName()));
    int hits = 0, instanced = 0, disagreements = 0;
    for (int s = 0; s < 6; ++s) {
        const TestScene scene(rng, s % 2 ? kFew : kMany);
        const Accelerator accelerator(scene.groups, scene.instances);
        for (int i = 0; i < 5000; ++i) {
            const Ray ray = RandomRay(rng);
            const float expected = scene.BruteForce(ray, Infinity);
            Hit hit;
            const bool found = accelerator.Intersect(ray, Infinity, &hit);
            if (found != (expected < Infinity) || (found && !Near(hit.t, expected))) {
                ++disagreements;
                continue;
            }
            hits += found;
            if (!found) continue;
            instanced += hit.instance >= 0;
            EXPECT_EQ(hit.group, hit.instance < 0 ? 0 : scene.instances[size_t(hit.instance)].group);
            disagreements += !Near(scene.Distance(ray, hit), hit.t);
        }
    }
    EXPECT_LE(disagreements, 2);
    EXPECT_GT(hits, 8000);
    EXPECT_GT(instanced, 2000);
}

class AcceleratorOf : public testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Shapes, AcceleratorOf, testing::Values(kFew, kMany));

TEST_P(AcceleratorOf, OccludedAgreesWithTheNearestHit) {
    Rng rng(SeedOf(FullTestName()));
    const TestScene scene(rng, GetParam());
    const Accelerator accelerator(scene.groups, scene.instances);
    int occluded = 0;
    for (int i = 0; i < 10000; ++i) {
        const Ray ray = RandomRay(rng);
        const float tMax = i % 4 ? 12 * rng.Uniform() : Infinity;
        Hit hit;
        const bool found = accelerator.Intersect(ray, tMax, &hit);
        ASSERT_TRUE(!found || hit.t < tMax);
        // The two code paths of the library share their arithmetic.
        ASSERT_EQ(accelerator.Occluded(ray, tMax), found);
        occluded += found;
    }
    EXPECT_GT(occluded, 1000);
}

TEST_P(AcceleratorOf, CoordinatesLeadBackToThePoint) {
    Rng rng(SeedOf(FullTestName()));
    const TestScene scene(rng, GetParam());
    const Accelerator accelerator(scene.groups, scene.instances);
    for (int i = 0; i < 3000; ++i) {
        const Ray ray = RandomRay(rng);
        Hit hit;
        if (!accelerator.Intersect(ray, Infinity, &hit) || hit.instance >= 0) continue;
        SurfaceInteraction si;
        scene.groups[0][size_t(hit.geometry)].shape->Interaction(ray, {hit.t, hit.coordinates}, hit.primitive,
                                                                 &si);
        EXPECT_LT(Length(si.p - ray(hit.t)), 1e-3f);
        EXPECT_NEAR(Length(si.n), 1, 1e-5f);
    }
}

TEST_P(AcceleratorOf, BoundsHoldAllMoments) {
    Rng rng(SeedOf(FullTestName()));
    const TestScene scene(rng, GetParam());
    const Accelerator accelerator(scene.groups, scene.instances);
    const Bounds3 bounds = accelerator.Bounds();
    for (int i = 0; i < 5000; ++i) {
        const Ray ray = RandomRay(rng);
        Hit hit;
        if (!accelerator.Intersect(ray, Infinity, &hit)) continue;
        const Point3 p = ray(hit.t);
        // The point rounds where it lies on the bounds.
        EXPECT_TRUE(Bounds3(bounds.min - 1e-4f, bounds.max + 1e-4f).Contains(p));
    }
    EXPECT_GT(accelerator.MemoryBytes(), 0u);
}

TEST(Accelerator, AnEmptySceneIsNeverHit) {
    const Accelerator accelerator({{}}, {});
    Hit hit;
    EXPECT_FALSE(accelerator.Intersect({{0, 0, 0}, {0, 0, 1}, 0}, Infinity, &hit));
    EXPECT_FALSE(accelerator.Occluded({{0, 0, 0}, {0, 0, 1}, 0}, Infinity));
    EXPECT_TRUE(accelerator.Bounds().IsEmpty());
}

std::unique_ptr<Shape> SphereAt(Point3 center, float radius) {
    return test::MakeShape(
        {"sphere", {Floats("float", "radius", {radius})}, Transform::Translate(Vec3(center))});
}

TEST(Accelerator, WorldsWithoutTrianglesAreHit) {
    const std::unique_ptr<Shape> sphere = SphereAt({1, 2, 3}, 0.5f);
    const auto expectHit = [](const Accelerator& accelerator, const Ray& ray, int instance) {
        Hit hit;
        ASSERT_TRUE(accelerator.Intersect(ray, Infinity, &hit));
        EXPECT_NEAR(hit.t, 2.5f, 1e-4f);
        EXPECT_EQ(hit.instance, instance);
        EXPECT_EQ(hit.geometry, 0);
        EXPECT_TRUE(accelerator.Occluded(ray, 3));
        EXPECT_FALSE(accelerator.Occluded(ray, 2));
        EXPECT_TRUE(accelerator.Bounds().Contains(ray(hit.t)));
    };
    expectHit(Accelerator({{{sphere.get(), nullptr}}}, {}), {{1, 2, 0}, {0, 0, 1}, 0}, -1);

    const AnimatedTransform moves(Transform(), 0, Transform::Translate({8, 0, 0}), 1);
    const Accelerator moving({{}, {{sphere.get(), nullptr}}}, {{1, moves}});
    expectHit(moving, {{1, 2, 0}, {0, 0, 1}, 0}, 0);
    expectHit(moving, {{9, 2, 0}, {0, 0, 1}, 1}, 0);
    EXPECT_FALSE(moving.Occluded({{1, 2, 0}, {0, 0, 1}, 1}, 3));
}

// As if Embree knew them: whether there are few of them or many makes no difference.
TEST(Accelerator, WhatIsTooLargeForEmbreeIsNowhere) {
    for (const int others : {1, 2 * FewBoxes::kMax}) {
        std::vector<std::unique_ptr<Shape>> shapes;
        shapes.push_back(SphereAt({0, 0, 0}, 1e19f));
        for (int i = 0; i < others; ++i) shapes.push_back(SphereAt({0, 0, 3.f + float(i)}, 0.5f));
        std::vector<AccelGeometry> world;
        for (const auto& shape : shapes) world.push_back({shape.get(), nullptr});
        // Moving ones as well, one of them for each other shape.
        const std::vector<AccelInstance> instances(
            size_t(others), {1, AnimatedTransform(Transform(), 0, Transform::Translate({1, 0, 0}), 1)});
        const Accelerator accelerator({world, {{shapes[0].get(), nullptr}}}, instances);
        Hit hit;
        EXPECT_TRUE(accelerator.Intersect({{0, 0, 0}, {0, 0, 1}, 0}, Infinity, &hit));
        EXPECT_EQ(hit.geometry, 1);
        EXPECT_FALSE(accelerator.Intersect({{0, 0, 0}, {1, 0, 0}, 0}, Infinity, &hit));
        EXPECT_FALSE(accelerator.Occluded({{0, 0, 0}, {1, 0, 0}, 0}, Infinity));
        EXPECT_LT(MaxComponent(accelerator.Bounds().max), 100) << others;
    }
}

// --- boxes side by side ---

/// The slab test in doubles, with a distance to spare or short of it.
bool MeetsBox(const Ray& ray, const Bounds3& box, double tMin, double tMax, double spare) {
    for (int axis = 0; axis < 3; ++axis) {
        if (double(box.min[axis]) - spare > double(box.max[axis]) + spare) return false;
        const double o = double(ray.o[axis]), d = double(ray.d[axis]), low = double(box.min[axis]) - spare,
                     high = double(box.max[axis]) + spare;
        if (d == 0) {
            if (o < low || o > high) return false;
            continue;
        }
        tMin = std::max(tMin, std::min((low - o) / d, (high - o) / d));
        tMax = std::min(tMax, std::max((low - o) / d, (high - o) / d));
    }
    return tMin <= tMax;
}

TEST(FewBoxes, FindThoseThatAreMetInTheirOrder) {
    constexpr double kSpare = 1e-5;
    Rng rng(SeedOf(FullTestName()));
    int numMet = 0;
    for (int i = 0; i < 4000; ++i) {
        FewBoxes boxes;
        std::vector<Bounds3> list;
        while (boxes.Size() < i % (FewBoxes::kMax + 1)) {
            list.emplace_back(RandomVector(rng, 3), RandomVector(rng, 3));
            if (i % 3 == 0) list.back().max.z = list.back().min.z;  // as of a disk
            boxes.Add(list.back());
        }
        Ray ray = RandomRay(rng);
        if (i % 5 == 0) ray.d = {0, i % 2 ? 1 : -1, 0};
        const float tMax = i % 4 ? 8 * rng.Uniform() : Infinity;
        std::vector<int> met;
        EXPECT_FALSE(boxes.AnyMet(ray, 0, tMax, [&](int k) {
            met.push_back(k);
            return false;
        }));
        EXPECT_TRUE(std::is_sorted(met.begin(), met.end()));
        for (int k = 0; k < boxes.Size(); ++k) {
            const bool isMet = std::count(met.begin(), met.end(), k) == 1;
            EXPECT_TRUE(isMet || !MeetsBox(ray, list[size_t(k)], 0, double(tMax), -kSpare));
            EXPECT_TRUE(!isMet || MeetsBox(ray, list[size_t(k)], 0, double(tMax), kSpare));
        }
        numMet += int(met.size());
        int asked = 0;
        EXPECT_EQ(boxes.AnyMet(ray, 0, tMax, [&](int) { return ++asked == 1; }), !met.empty());
        EXPECT_EQ(asked, std::min(1, int(met.size())));
    }
    EXPECT_GT(numMet, 1000);
}

TEST(FewBoxes, RaysInThePlaneOfAFlatBoxMeetIt) {
    FewBoxes boxes;
    boxes.Add(Bounds3({-1, -1, 0}, {1, 1, 0}));
    const auto isMet = [&](const Ray& ray) {
        return boxes.AnyMet(ray, 0, Infinity, [](int) { return true; });
    };
    EXPECT_TRUE(isMet({{-2, 0, 0}, {1, 0, 0}, 0}));
    EXPECT_FALSE(isMet({{-2, 0, 1e-3f}, {1, 0, 0}, 0}));
    EXPECT_FALSE(isMet({{-2, 2, 0}, {1, 0, 0}, 0}));
}

// --- alpha ---

std::unique_ptr<Shape> QuadAt(float z, const std::string& kind) {
    const Transform t = Transform::Translate({0, 0, z});
    if (kind == "trianglemesh")
        return test::MakeShape(
            {kind,
             {Floats("point3", "P", {-2, -2, 0, 2, -2, 0, 2, 2, 0, -2, 2, 0}),
              Integers("indices", {0, 1, 2, 0, 2, 3}), Floats("point2", "uv", {0, 0, 1, 0, 1, 1, 0, 1})},
             t});
    if (kind == "bilinearmesh")
        return test::MakeShape({kind,
                                {Floats("point3", "P", {-2, -2, 0, 2, -2, 0, -2, 2, 0, 2, 2, 0}),
                                 Integers("indices", {0, 1, 2, 3})},
                                t});
    // A disk; or a ball or a tube, which a ray meets twice.
    const Transform lying = kind == "cylinder" ? t * Transform::Rotate(90, {1, 0, 0}) : t;
    return test::MakeShape({kind, {Floats("float", "radius", {3})}, lying});
}
/// Rays downwards onto the square [-1, 1]^2.
Ray Downwards(Rng& rng) { return {{2 * rng.Uniform() - 1, 2 * rng.Uniform() - 1, 5}, {0, 0, -1}, 0}; }

/// Where alpha stands in the tests below: how many layers, of which kind.
Outcome StopRate(const std::string& kind, float alpha, int layers, bool instanced, double expected,
                 uint64_t seed) {
    const FloatConstantTexture texture(alpha);
    std::vector<std::unique_ptr<Shape>> shapes;
    std::vector<std::vector<AccelGeometry>> groups(2);
    for (int i = 0; i < layers; ++i) {
        shapes.push_back(QuadAt(float(i), kind));
        groups[instanced].push_back({shapes.back().get(), &texture});
    }
    std::vector<AccelInstance> instances;
    if (instanced) instances.push_back({1, AnimatedTransform(Transform::Translate({0.1f, 0, 0}))});
    const Accelerator accelerator(groups, instances);
    Rng rng(seed);
    RunningMean stopped;
    for (int i = 0; i < 20000; ++i) {
        const Ray ray = Downwards(rng);
        Hit hit;
        const bool found = accelerator.Intersect(ray, Infinity, &hit);
        EXPECT_EQ(accelerator.Occluded(ray, Infinity), found);
        EXPECT_EQ(accelerator.Intersect(ray, Infinity, &hit), found);
        stopped.Add(found ? 1 : 0);
    }
    return ZTest(stopped, expected, 0, kind);
}

// Power: 20,000 rays have a standard error of 0.0035; a rate off by 0.02 is 5.7 of them. 1e-5 for each of 12
// runs.
TEST(Alpha, IsTheProbabilityOfAHit) {
    for (const std::string kind : {"trianglemesh", "bilinearmesh", "disk"})
        for (const bool instanced : {false, true}) {
            EXPECT_TRUE(Passes(FullTestName() + kind + "/half", 1e-5,
                               [&](uint64_t seed) { return StopRate(kind, 0.5f, 1, instanced, 0.5, seed); }));
            // Layers along one ray decide independently.
            EXPECT_TRUE(Passes(FullTestName() + kind + "/layers", 1e-5, [&](uint64_t seed) {
                return StopRate(kind, 0.3f, 3, instanced, 1 - 0.7 * 0.7 * 0.7, seed);
            }));
        }
}

TEST(Alpha, BehindAHoleIsTheOtherSide) {
    for (const std::string kind : {"sphere", "cylinder"})
        for (const bool instanced : {false, true})
            EXPECT_TRUE(Passes(FullTestName() + kind, 1e-5, [&](uint64_t seed) {
                return StopRate(kind, 0.5f, 1, instanced, 0.75, seed);
            }));
}

TEST(Alpha, NegativeControlARateOffByTwoPercentIsFound) {
    EXPECT_LT(StopRate("trianglemesh", 0.52f, 1, false, 0.5, SeedOf(FullTestName())).pValue, 1e-5);
}

TEST(Alpha, ZeroAndOneAreCertain) {
    for (const std::string kind : {"trianglemesh", "disk"}) {
        EXPECT_EQ(StopRate(kind, 0, 2, false, 0, 1).pValue, 1);
        EXPECT_EQ(StopRate(kind, 1, 1, false, 1, 1).pValue, 1);
    }
}

/// A hole where u < 1/2.
class HalfHole final : public FloatTexture {
  public:
    float Evaluate(const TextureContext& context) const override { return context.uv.x < 0.5f ? 0.f : 1.f; }
};

TEST(Alpha, TexturesAreEvaluatedWhereTheRayHits) {
    const HalfHole texture;
    for (const std::string kind : {"trianglemesh", "bilinearmesh"}) {
        const auto shape = QuadAt(0, kind);
        const Accelerator accelerator({{{shape.get(), &texture}}}, {});
        Rng rng(SeedOf(FullTestName()));
        for (int i = 0; i < 1000; ++i) {
            const Ray ray = Downwards(rng);
            if (std::abs(ray.o.x) < 1e-5f) continue;
            EXPECT_EQ(accelerator.Occluded(ray, Infinity), ray.o.x > 0) << kind;
        }
    }
}

}  // namespace
}  // namespace lacquer::accelerator_test
