// The camera "spherical": both mappings.
#include <gtest/gtest.h>

#include "pbrt/base/camera.h"
#include "pbrt/core/rng.h"
#include "support/scene_parts.h"
#include "support/statistics.h"

namespace lacquer::spherical_test {
namespace {

using test::FullTestName;
using test::SeedOf;

const std::string kEqualArea = "\"string mapping\" \"equalarea\"";
const std::string kEquirectangular = "\"string mapping\" \"equirectangular\"";
constexpr Int2 kResolution(160, 80);

std::unique_ptr<Camera> MakeCamera(const std::string& text, Int2 resolution = kResolution,
                                   const AnimatedTransform& renderFromCamera = {}) {
    const Params params = test::ParamsFromText("camera", text);
    auto camera = Registry<CameraKind>::Find("spherical")({params, renderFromCamera, resolution});
    params.CheckAllUsed();
    return camera;
}
CameraRay RayAt(const Camera& camera, Point2 film, float time = 0) {
    return camera.GenerateRay({film, Point2(0.5f), time}).value();
}
/// Direction at a point of the unit square, (0,0) being the top left corner of the image.
Vec3 Along(const Camera& camera, Point2 uv) { return RayAt(camera, uv * Vec2(kResolution)).ray.d; }
// Unit vectors of a few float operations.
void ExpectNear(Vec3 a, Vec3 b, float tolerance = 3e-6f) {
    EXPECT_LT(Length(a - b), tolerance)
        << a.x << " " << a.y << " " << a.z << " instead of " << b.x << " " << b.y << " " << b.z;
}

TEST(SphericalCamera, EquirectangularRowsGoFromPlusYToMinusY) {
    const auto camera = MakeCamera(kEquirectangular);
    for (const float u : {0.f, 0.3f, 1.f}) {
        ExpectNear(Along(*camera, {u, 0}), {0, 1, 0});
        ExpectNear(Along(*camera, {u, 1}), {0, -1, 0});
    }
    // Along the middle row from +x over +z, -x and -z back to +x.
    ExpectNear(Along(*camera, {0, 0.5f}), {1, 0, 0});
    ExpectNear(Along(*camera, {0.25f, 0.5f}), {0, 0, 1});
    ExpectNear(Along(*camera, {0.5f, 0.5f}), {-1, 0, 0});
    ExpectNear(Along(*camera, {0.75f, 0.5f}), {0, 0, -1});
    ExpectNear(Along(*camera, {1, 0.5f}), {1, 0, 0});
    const float s = std::sqrt(0.5f);
    ExpectNear(Along(*camera, {0.25f, 0.25f}), {0, s, s});
}

TEST(SphericalCamera, EqualAreaIsTheDefaultItsCentreIsPlusYItsCornersAreMinusY) {
    for (const std::string& text : {kEqualArea, std::string()}) {
        const auto camera = MakeCamera(text);
        ExpectNear(Along(*camera, {0.5f, 0.5f}), {0, 1, 0});
        for (const Point2 corner : {Point2(0, 0), Point2(1, 0), Point2(0, 1), Point2(1, 1)})
            ExpectNear(Along(*camera, corner), {0, -1, 0});
        ExpectNear(Along(*camera, {1, 0.5f}), {1, 0, 0});
        ExpectNear(Along(*camera, {0, 0.5f}), {-1, 0, 0});
        ExpectNear(Along(*camera, {0.5f, 1}), {0, 0, 1});
        ExpectNear(Along(*camera, {0.5f, 0}), {0, 0, -1});
    }
}

TEST(SphericalCamera, RaysStartAtThePointWithUnitDirectionsAndWeightOne) {
    // Under a scale that mirrors, too; far beyond the edges, where a wide filter may lead.
    const AnimatedTransform moved(Transform::Translate({1, 2, 3}) * Transform::Scale({3, 3, -3}));
    Rng rng(SeedOf(FullTestName()));
    for (const std::string& text : {kEqualArea, kEquirectangular}) {
        const auto camera = MakeCamera(text, kResolution, moved);
        for (int i = 0; i < 2000; ++i) {
            const Point2 film = Vec2(kResolution) * (8.f * rng.Uniform2D() - Point2(4));
            const CameraRay ray = RayAt(*camera, film);
            EXPECT_EQ(ray.weight, 1);
            for (const Vec3 d : {ray.ray.d, ray.rxDirection, ray.ryDirection})
                EXPECT_NEAR(Length(d), 1, 1e-5f) << film.x << " " << film.y;
            for (const Point3 o : {ray.ray.o, ray.rxOrigin, ray.ryOrigin}) EXPECT_EQ(o, Point3(1, 2, 3));
        }
    }
}

/// Sum over all pixels of the solid angle that their differentials span.
double TotalSolidAngle(const Camera& camera, Int2 resolution) {
    double sum = 0;
    for (int y = 0; y < resolution.y; ++y)
        for (int x = 0; x < resolution.x; ++x) {
            // From the corner of the pixel: of its neighbours, one is to the right and one below.
            const CameraRay r = RayAt(camera, Point2(float(x), float(y)));
            sum += double(Length(Cross(r.rxDirection - r.ray.d, r.ryDirection - r.ray.d)));
        }
    return sum;
}

TEST(SphericalCamera, PixelsTileTheSphere) {
    const Int2 resolution(512, 256);
    for (const std::string& text : {kEqualArea, kEquirectangular}) {
        // Parallelograms of chords in place of patches: errors of the order of a pixel's size, 2 pi / 512.
        const double total = TotalSolidAngle(*MakeCamera(text, resolution), resolution);
        EXPECT_NEAR(total / (4 * double(Pi)), 1, 0.012) << text;
    }
}

TEST(SphericalCamera, PixelsOfEqualAreaHaveEqualSolidAngles) {
    const Int2 resolution(256, 256);
    const auto camera = MakeCamera(kEqualArea, resolution);
    // Uniform directions have mean 0 and the moments 1/3 and 1/15: those of a midpoint rule of 256^2 cells.
    double first = 0, second = 0, mixed = 0;
    for (int y = 0; y < resolution.y; ++y)
        for (int x = 0; x < resolution.x; ++x) {
            const Vec3 d = RayAt(*camera, {float(x) + 0.5f, float(y) + 0.5f}).ray.d;
            first += double(d.x + 2 * d.y + 4 * d.z);
            second += double(d.y * d.y);
            mixed += double(Sqr(d.x * d.y));
        }
    const double n = 256. * 256;
    EXPECT_NEAR(first / n, 0, 1e-4);
    EXPECT_NEAR(second / n, 1. / 3, 1e-4);
    EXPECT_NEAR(mixed / n, 1. / 15, 1e-4);
}

TEST(SphericalCamera, ImagesGoOnBeyondTheirEdges) {
    const float h = 1e-3f;
    for (const std::string& text : {kEqualArea, kEquirectangular}) {
        const auto camera = MakeCamera(text);
        // From one side of an edge to the other, the direction changes as little as anywhere.
        for (int i = 0; i < 100; ++i) {
            const float t = (float(i) + 0.5f) / 100;
            for (const auto& [edge, across] :
                 {std::pair(Point2(t, 0), Vec2(0, h)), std::pair(Point2(t, 1), Vec2(0, h)),
                  std::pair(Point2(0, t), Vec2(h, 0)), std::pair(Point2(1, t), Vec2(h, 0))}) {
                const Vec3 a = Along(*camera, edge - across), b = Along(*camera, edge),
                           c = Along(*camera, edge + across);
                // 2 pi h at most for one step, twice that for a crossing of the pole's neighbourhood.
                EXPECT_LT(Length(a - b), 15 * h) << text << edge.x << " " << edge.y;
                EXPECT_LT(Length(c - b), 15 * h) << text << edge.x << " " << edge.y;
            }
        }
    }
    // Equirectangular: around, and over the pole to the opposite meridian. Equal area: the edge turned over.
    const auto around = MakeCamera(kEquirectangular), folded = MakeCamera(kEqualArea);
    ExpectNear(Along(*around, {1.2f, 0.3f}), Along(*around, {0.2f, 0.3f}));
    ExpectNear(Along(*around, {0.2f, -0.1f}), Along(*around, {0.7f, 0.1f}));
    ExpectNear(Along(*folded, {-0.1f, 0.3f}), Along(*folded, {0.1f, 0.7f}));
    ExpectNear(Along(*folded, {0.3f, 1.1f}), Along(*folded, {0.7f, 0.9f}));
    ExpectNear(Along(*folded, {2.3f, -3.8f}), Along(*folded, {0.3f, 0.2f}), 1e-5f);
}

TEST(SphericalCamera, DifferentialsAreTheNeighbouringRays) {
    Rng rng(SeedOf(FullTestName()));
    for (const std::string& text : {kEqualArea, kEquirectangular}) {
        const auto camera =
            MakeCamera(text, kResolution, AnimatedTransform(Transform::Rotate(30, {1, 1, 0})));
        for (int i = 0; i < 200; ++i) {
            const Point2 film = rng.Uniform2D() * Vec2(kResolution);
            const CameraRay ray = RayAt(*camera, film);
            ExpectNear(ray.rxDirection, RayAt(*camera, film + Point2(1, 0)).ray.d);
            ExpectNear(ray.ryDirection, RayAt(*camera, film + Point2(0, 1)).ray.d);
        }
    }
}

TEST(SphericalCamera, MovesWithItsTransform) {
    const AnimatedTransform moving(Transform(), 0,
                                   Transform::Translate({2, 0, 0}) * Transform::Rotate(90, {0, 1, 0}), 1);
    const auto camera = MakeCamera(kEquirectangular + " \"float shutterclose\" 1", kResolution, moving);
    const CameraRay middle = RayAt(*camera, {40, 40}, 0.5f);  // looks along +z
    ExpectNear(middle.ray.o, {1, 0, 0});
    ExpectNear(middle.ray.d, {std::sqrt(0.5f), 0, std::sqrt(0.5f)});
    EXPECT_EQ(middle.ray.time, 0.5f);
}

TEST(SphericalCamera, ToleratesWhatOtherCamerasNeedAndNothingElse) {
    EXPECT_NO_THROW(MakeCamera(kEqualArea +
                               " \"float lensradius\" 1 \"float focaldistance\" 3 "
                               "\"float frameaspectratio\" 2 \"float screenwindow\" [-1 1 -1 1]"));
    for (const auto& [text, part] :
         {std::pair<std::string, std::string>("\"string mapping\" \"equalrectangular\"",
                                              "did you mean \"equirectangular\"?"),
          {"\"string mapping\" \"EqualArea\"", "\"equalarea\""},
          {"\"float shutterclose\" 0", "the shutter closes at 0 but opens at 0; it must close later"},
          {"\"float fov\" 90", "fov"}}) {
        std::string error;
        try {
            MakeCamera(text);
        } catch (const std::exception& e) {
            error = e.what();
        }
        EXPECT_NE(error.find(part), std::string::npos) << text << " says: " << error;
        EXPECT_NE(error.find("scene.pbrt:1:"), std::string::npos) << error;
    }
}

}  // namespace
}  // namespace lacquer::spherical_test
