// Shapes as emitters: areas, densities over area and over solid angle.
#include <gtest/gtest.h>

#include "pbrt/core/rng.h"
#include "pbrt/core/sampling.h"
#include "shapes/shape_test_support.h"
#include "support/statistics.h"

namespace lacquer::test::shape_sampling_test {

namespace {

// All checks of this file together raise a false alarm once in a thousand runs.
constexpr int kNumChecks = 80;
const double kAlpha = SidakAlpha(1e-3, kNumChecks);

const std::vector<float> kTriangle = {-1, -1, 0, 1, -1, 0.3f, 0, 1, 0};
const std::vector<float> kRectangle = {-1, -1, 0, 1, -1, 0, -1, 1, 0, 1, 1, 0};
const std::vector<float> kParallelogram = {-1, -1, 0, 1, -1, 0, -0.5f, 1, 0, 1.5f, 1, 0};
const std::vector<float> kCurved = {-1, -0.8f, -0.5f, 1, -0.8f, 0.5f, -1, 0.9f, 0.6f, 1, 0.9f, -0.6f};

const Normal3 kFacing = Normalize(Vec3(-1, -2, -1)), kAside = Normalize(Vec3(2, -1, 0));

// Number of meetings with the primitive in the direction w, weighted by f(w).
float CountHits(const Shape& shape, Point3 from, Vec3 w) {
    float count = 0, tMin = 0;
    while (const auto hit = shape.Intersect({from, w}, tMin, Infinity, 0)) {
        ++count;
        tMin = hit->t * 1.0001f + 1e-5f;
        if (count > 3) break;
    }
    return count;
}

float TestFunction(Vec3 w) { return Sqr(1 + w.x - 0.5f * w.y) + 0.2f; }

struct Emitter {
    std::string label;
    ShapeSetup setup;
    Point3 from;
    bool nearestOnly = false;  // the sampler draws only points that are seen
    Normal3 ns{0};             // of the surface there; zero in a medium

    LightReference Reference() const {
        LightReference reference(from);
        reference.n = reference.ns = ns;
        return reference;
    }
};

std::vector<Emitter> Emitters() {
    const ShapeSetup sphere{"sphere", {Floats("float", "radius", {1.2f})}};
    ShapeSetup movedSphere = sphere, ellipsoid = sphere, scaledSphere = sphere, cylinder{"cylinder", {}},
               disk{"disk", {}}, scaledDisk = disk;
    movedSphere.renderFromObject = SomeRigidTransform();
    ellipsoid.renderFromObject = SomeAffineTransform();
    scaledSphere.renderFromObject = Transform::Scale({2, 2, 2});
    cylinder.renderFromObject = SomeMirroringTransform();
    scaledDisk.renderFromObject = SomeAffineTransform();
    return {
        {"SphereFromOutside", sphere, {0.5f, 2, 1.5f}, true},
        {"SphereFromNearby", sphere, {0.3f, 0.1f, 1.17f}, true},
        {"SphereFromVeryNear", sphere, {0, 0, 1.20002f}, true},
        {"SphereFromInside", sphere, {0.3f, 0.1f, -0.4f}},
        {"SphereMoved", movedSphere, {2, -3, 4}, true},
        {"SphereScaled", scaledSphere, {0, 4, 1}, true},
        {"Ellipsoid", ellipsoid, {6, -3, 2}},
        {"Cylinder", cylinder, {3, -1, 2}},
        {"Disk", disk, {0.3f, 0.5f, 0.8f}},
        {"DiskScaled", scaledDisk, {3, -2, 2}},
        {"Triangle", {"trianglemesh", {Floats("point3", "P", kTriangle)}}, {0.2f, 0.3f, 0.9f}},
        {"TriangleClose", {"trianglemesh", {Floats("point3", "P", kTriangle)}}, {0.1f, -0.2f, 0.2f}},
        {"TriangleOblique", {"trianglemesh", {Floats("point3", "P", kTriangle)}}, {4, 0.3f, 1.5f}},
        {"TriangleFromSurface",
         {"trianglemesh", {Floats("point3", "P", kTriangle)}},
         {1, 2, 1.5f},
         false,
         kFacing},
        {"TriangleThroughHorizon",
         {"trianglemesh", {Floats("point3", "P", kTriangle)}},
         {1, 2, 1.5f},
         false,
         kAside},
        {"Rectangle", {"bilinearmesh", {Floats("point3", "P", kRectangle)}}, {0.4f, 0.3f, 0.5f}},
        {"RectangleFromBehind", {"bilinearmesh", {Floats("point3", "P", kRectangle)}}, {2, -1.5f, -0.6f}},
        {"Parallelogram", {"bilinearmesh", {Floats("point3", "P", kParallelogram)}}, {0.4f, 0.3f, 1.2f}},
        {"CurvedPatch", {"bilinearmesh", {Floats("point3", "P", kCurved)}}, {0.3f, 0.2f, 2}},
    };
}

}  // namespace

class EmitterSampling : public testing::TestWithParam<int> {
  protected:
    EmitterSampling() : emitter_(Emitters()[size_t(GetParam())]), shape_(MakeShape(emitter_.setup)) {}

    // The integral of TestFunction over the directions in which the shape lies, by SampleSolidAngle with
    // densities times `tamper`, against uniform directions in a cone that holds its box.
    Outcome CompareIntegrals(uint64_t seed, double tamper) const {
        Rng rng(seed);
        const LightReference ref = emitter_.Reference();
        const Bounds3 box = shape_->Bounds(0);
        const Vec3 toCenter = box.Center() - ref.p;
        const float radius = Length(box.Diagonal()) / 2, distance = Length(toCenter);
        const float cosMax = distance > radius ? SafeSqrt(1 - Sqr(radius / distance)) : -1.f;
        const Frame frame = Frame::FromZ(Normalize(toCenter));
        RunningMean difference;
        for (int i = 0; i < 60000; ++i) {
            double estimate = 0;
            if (const auto sample = shape_->SampleSolidAngle(0, ref, rng.Uniform2D(), true)) {
                const Vec3 w = Normalize(sample->p - ref.p);
                estimate = double(TestFunction(w) / sample->pdf) / tamper;
            }
            // Uniform directions are noisier: four for each sample.
            for (int k = 0; k < 4; ++k) {
                const Vec3 w = frame.FromLocal(SampleUniformCone(rng.Uniform2D(), cosMax));
                float count = CountHits(*shape_, ref.p, w);
                if (emitter_.nearestOnly) count = std::min(count, 1.f);
                estimate -= double(count * TestFunction(w) / (4 * PdfUniformCone(1 - cosMax)));
            }
            difference.Add(estimate);
        }
        return ZTest(difference, 0, 0, emitter_.label);
    }

    Emitter emitter_;
    std::unique_ptr<Shape> shape_;
};

TEST_P(EmitterSampling, IntegratesLikeUniformDirections) {
    EXPECT_TRUE(Passes(FullTestName(), kAlpha, [&](uint64_t seed) { return CompareIntegrals(seed, 1); }));
}

// Power: at 60,000 samples a density 15 % off lies more than 7 standard errors away for every emitter.
TEST_P(EmitterSampling, FindsAWrongDensity) {
    EXPECT_LT(CompareIntegrals(SeedOf(FullTestName()), 1.15).pValue, kAlpha);
}

TEST_P(EmitterSampling, SampleAndPdfAgree) {
    Rng rng(SeedOf(FullTestName()));
    const LightReference ref = emitter_.Reference();
    for (int i = 0; i < 2000; ++i) {
        const auto sample = shape_->SampleSolidAngle(0, ref, rng.Uniform2D(), true);
        ASSERT_TRUE(sample);
        const float pdf = shape_->PdfSolidAngle(0, ref, sample->p, sample->n);
        // Edge-on, the rounding of p changes the cosine; away from that both are the same to rounding.
        const float cosine = AbsDot(sample->n, Normalize(sample->p - ref.p));
        EXPECT_NEAR(pdf / sample->pdf, 1, 3e-5f + 2e-6f / cosine) << "cosine " << cosine;
    }
}

// Densities of triangles at any unit of lengths, and next to their edges, where a ray may meet them by
// rounding.
TEST(TriangleSampling, SampleAndPdfAgreeAtAnyScale) {
    Rng rng(SeedOf(FullTestName()));
    for (const float unit : {1e-13f, 1e-10f, 1e-6f, 1.f, 1e6f, 1e10f}) {
        std::vector<float> p = kTriangle;
        for (float& x : p) x *= unit;
        const auto triangle = MakeShape({"trianglemesh", {Floats("point3", "P", p)}});
        LightReference ref(unit * Point3(1, 2, 3));
        ref.n = ref.ns = kFacing;
        for (int i = 0; i < 100; ++i) {
            const auto sample = triangle->SampleSolidAngle(0, ref, rng.Uniform2D(), true);
            ASSERT_TRUE(sample) << unit;
            const float pdf = triangle->PdfSolidAngle(0, ref, sample->p, sample->n);
            EXPECT_NEAR(pdf / sample->pdf, 1, 1e-4f) << unit;
        }
        const Point3 corner = unit * Point3(-1, -1, 0), beside = unit * Point3(-1.001f, -1.001f, 0);
        const float atCorner = triangle->PdfSolidAngle(0, ref, corner, Normal3(0, 0, 1));
        EXPECT_GT(atCorner, 0);
        EXPECT_NEAR(triangle->PdfSolidAngle(0, ref, beside, Normal3(0, 0, 1)) / atCorner, 1, 0.01f) << unit;
    }
}

TEST_P(EmitterSampling, IsTheSameWithoutSurfaceParameters) {
    Rng rng(SeedOf(FullTestName()));
    const LightReference ref = emitter_.Reference();
    for (int i = 0; i < 200; ++i) {
        const Point2 u = rng.Uniform2D();
        const auto sample = shape_->SampleSolidAngle(0, ref, u, true),
                   without = shape_->SampleSolidAngle(0, ref, u, false);
        ASSERT_TRUE(sample && without);
        EXPECT_EQ(sample->p, without->p);
        EXPECT_EQ(sample->n, without->n);
        EXPECT_EQ(sample->pError, without->pError);
        EXPECT_EQ(sample->pdf, without->pdf);
    }
}

INSTANTIATE_TEST_SUITE_P(All, EmitterSampling, testing::Range(0, int(Emitters().size())),
                         [](const auto& row) { return Emitters()[size_t(row.param)].label; });

TEST(ShapeArea, ClosedForms) {
    EXPECT_NEAR(MakeShape({"sphere", {Floats("float", "radius", {2})}})->Area(0), 16 * Pi, 1e-4f);
    EXPECT_NEAR(
        MakeShape({"sphere", {Floats("float", "zmin", {0}), Floats("float", "phimax", {90})}})->Area(0),
        Pi / 2, 1e-6f);
    EXPECT_NEAR(MakeShape({"cylinder", {Floats("float", "radius", {0.5f})}})->Area(0), 2 * Pi, 1e-5f);
    EXPECT_NEAR(MakeShape({"disk", {Floats("float", "innerradius", {0.5f})}})->Area(0), 0.75f * Pi, 1e-6f);
    EXPECT_NEAR(MakeShape({"bilinearmesh", {Floats("point3", "P", kParallelogram)}})->Area(0), 4, 1e-6f);
    EXPECT_NEAR(MakeShape({"trianglemesh", {Floats("point3", "P", {0, 0, 0, 3, 0, 0, 0, 4, 0})}})->Area(0), 6,
                1e-6f);
}

TEST(ShapeArea, OfACurvedPatchByFineTriangles) {
    const auto patch = MakeShape({"bilinearmesh", {Floats("point3", "P", kCurved)}});
    const auto at = [](double u, double v) {
        glm::dvec3 p(0);
        for (int i = 0; i < 4; ++i)
            p += (i & 1 ? u : 1 - u) * (i & 2 ? v : 1 - v) *
                 glm::dvec3(kCurved[size_t(3 * i)], kCurved[size_t(3 * i + 1)], kCurved[size_t(3 * i + 2)]);
        return p;
    };
    const int n = 300;
    double area = 0;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const auto a = at(double(i) / n, double(j) / n), b = at(double(i + 1) / n, double(j) / n),
                       c = at(double(i) / n, double(j + 1) / n), d = at(double(i + 1) / n, double(j + 1) / n);
            area += 0.5 * (glm::length(glm::cross(b - a, c - a)) + glm::length(glm::cross(b - d, c - d)));
        }
    EXPECT_NEAR(double(patch->Area(0)), area, 1e-4 * area);
}

// 1 / pdf averages to the area of the transformed surface; for the ellipsoid (1, 1, 2) that is known.
TEST(ShapeArea, DensitiesAreThoseOfTheScaledSurface) {
    ShapeSetup setup{"sphere", {}};
    setup.renderFromObject = Transform::Translate({3, 1, 2}) * Transform::Scale({1, 1, 2});
    const auto shape = MakeShape(setup);
    const double e = std::sqrt(1 - 0.25), area = 2 * double(Pi) * (1 + 2 / e * std::asin(e));
    EXPECT_TRUE(Passes(FullTestName(), kAlpha, [&](uint64_t seed) {
        Rng rng(seed);
        RunningMean mean;
        for (int i = 0; i < 20000; ++i) mean.Add(double(1 / shape->SampleArea(0, rng.Uniform2D())->pdf));
        return ZTest(mean, area, 1e-5 * area, "area");
    }));
}

TEST(SphereSampling, TinyConesKeepTheirSolidAngle) {
    const auto sphere = MakeShape({"sphere", {}});
    for (const float distance : {2.f, 30.f, 1e3f, 1e5f, 1e7f}) {
        const LightReference ref(Point3(0, distance, 0));
        const double sin2 = 1 / (double(distance) * double(distance));
        const double solidAngle = 2 * double(Pi) * sin2 / (1 + std::sqrt(1 - sin2));
        const auto sample = sphere->SampleSolidAngle(0, ref, {0.3f, 0.7f}, true);
        ASSERT_TRUE(sample);
        EXPECT_NEAR(double(sample->pdf) * solidAngle, 1, 1e-6) << distance;
        EXPECT_NEAR(Length(sample->p), 1, 1e-5f);
        EXPECT_GE(sample->p.y, 1 / distance - 1e-5f);
        EXPECT_EQ(sample->pdf, sphere->PdfSolidAngle(0, ref, sample->p, sample->n));
    }
}

TEST(ShapeSampling, DegenerateEmittersGiveNothing) {
    const auto line = MakeShape({"trianglemesh", {Floats("point3", "P", {0, 0, 0, 1, 0, 0, 2, 0, 0})}});
    EXPECT_FALSE(line->SampleArea(0, {0.3f, 0.4f}));
    EXPECT_FALSE(line->SampleSolidAngle(0, LightReference(Point3(0, 1, 0)), {0.3f, 0.4f}, true));
    const auto point =
        MakeShape({"bilinearmesh", {Floats("point3", "P", {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0})}});
    EXPECT_FALSE(point->SampleArea(0, {0.3f, 0.4f}));
    EXPECT_FALSE(point->SampleSolidAngle(0, LightReference(Point3(0, 1, 0)), {0.3f, 0.4f}, true));
    const auto rectangle = MakeShape({"bilinearmesh", {Floats("point3", "P", kRectangle)}});
    const auto edgeOn = rectangle->SampleSolidAngle(0, LightReference(Point3(5, 0, 0)), {0.3f, 0.4f}, true);
    EXPECT_TRUE(!edgeOn || std::isfinite(edgeOn->pdf));
}

TEST(ShapeSampling, NormalConesHoldTheNormals) {
    const auto shape = MakeShape({"bilinearmesh", {Floats("point3", "P", kCurved)}});
    const auto [axis, cosine] = shape->NormalCone(0);
    EXPECT_GT(cosine, 0.3f);
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 1000; ++i)
        EXPECT_GE(Dot(shape->SampleArea(0, rng.Uniform2D())->n, axis), cosine - 1e-5f);
    EXPECT_EQ(MakeShape({"sphere", {}})->NormalCone(0).second, -1);
}

}  // namespace lacquer::test::shape_sampling_test
