#include <gtest/gtest.h>

#include "pbrt/base/camera.h"
#include "pbrt/core/rng.h"
#include "support/scene_parts.h"
#include "support/statistics.h"

namespace lacquer::projective_test {
namespace {

using test::FullTestName;
using test::SeedOf;

std::unique_ptr<Camera> MakeCamera(const std::string& type, const std::string& text,
                                   Int2 resolution = {200, 100},
                                   const AnimatedTransform& renderFromCamera = {}) {
    const Params params = test::ParamsFromText("camera", text);
    auto camera = Registry<CameraKind>::Find(type)({params, renderFromCamera, resolution});
    params.CheckAllUsed();
    return camera;
}
std::string ErrorOf(const std::string& type, const std::string& text) {
    try {
        MakeCamera(type, text);
    } catch (const SceneError& e) {
        return e.what();
    } catch (const SceneErrors& e) {
        return e.what();
    }
    return "";
}
CameraRay RayAt(const Camera& camera, Point2 film, Point2 lens = Point2(0.5f), float time = 0) {
    return camera.GenerateRay({film, lens, time}).value();
}
// Unit vectors of a few float operations.
void ExpectNear(Vec3 a, Vec3 b, float tolerance = 2e-6f) {
    EXPECT_LT(Length(a - b), tolerance)
        << a.x << " " << a.y << " " << a.z << " instead of " << b.x << " " << b.y << " " << b.z;
}

TEST(Perspective, CenterLooksStraightAhead) {
    for (const Int2 resolution : {Int2(200, 100), Int2(33, 77), Int2(1, 1)}) {
        const auto camera = MakeCamera("perspective", "", resolution);
        const CameraRay ray = RayAt(*camera, Point2(resolution) / 2.f);
        ExpectNear(ray.ray.o, {0, 0, 0});
        ExpectNear(ray.ray.d, {0, 0, 1});
        EXPECT_EQ(ray.weight, 1);
    }
}

TEST(Perspective, FovSpansTheShorterAxis) {
    const float t = std::tan(Radians(30));
    const auto wide = MakeCamera("perspective", "\"float fov\" 60", {200, 100});
    ExpectNear(RayAt(*wide, {0, 0}).ray.d, Normalize(Vec3(-2 * t, t, 1)));
    ExpectNear(RayAt(*wide, {200, 100}).ray.d, Normalize(Vec3(2 * t, -t, 1)));
    ExpectNear(RayAt(*wide, {150, 25}).ray.d, Normalize(Vec3(t, t / 2, 1)));
    const auto tall = MakeCamera("perspective", "\"float fov\" 60", {100, 200});
    ExpectNear(RayAt(*tall, {0, 0}).ray.d, Normalize(Vec3(-t, 2 * t, 1)));
    // The default is a right angle.
    ExpectNear(RayAt(*MakeCamera("perspective", "", {100, 100}), {100, 100}).ray.d,
               Normalize(Vec3(1, -1, 1)));
}

TEST(Perspective, AspectRatioAndScreenWindowReplaceTheFrame) {
    const float t = std::tan(Radians(20));
    const auto square = MakeCamera("perspective", "\"float fov\" 40 \"float frameaspectratio\" 1");
    ExpectNear(RayAt(*square, {0, 0}).ray.d, Normalize(Vec3(-t, t, 1)));
    const auto narrow = MakeCamera("perspective", "\"float fov\" 40 \"float frameaspectratio\" 0.5");
    ExpectNear(RayAt(*narrow, {0, 0}).ray.d, Normalize(Vec3(-t, 2 * t, 1)));
    const auto window = MakeCamera("perspective", "\"float fov\" 40 \"float screenwindow\" [-0.5 1 -2 3]");
    ExpectNear(RayAt(*window, {0, 0}).ray.d, Normalize(Vec3(-0.5f * t, 3 * t, 1)));
    ExpectNear(RayAt(*window, {200, 100}).ray.d, Normalize(Vec3(t, -2 * t, 1)));
}

TEST(Orthographic, RaysAreParallelAndScreenUnitsAreSceneUnits) {
    const auto camera = MakeCamera("orthographic", "");
    for (const auto& [film, origin] :
         {std::pair(Point2(0, 0), Point3(-2, 1, 0)), std::pair(Point2(100, 50), Point3(0)),
          std::pair(Point2(200, 100), Point3(2, -1, 0))}) {
        const CameraRay ray = RayAt(*camera, film);
        ExpectNear(ray.ray.o, origin);
        ExpectNear(ray.ray.d, {0, 0, 1});
    }
    const auto window = MakeCamera("orthographic", "\"float screenwindow\" [-5 1 -2 3]");
    ExpectNear(RayAt(*window, {0, 100}).ray.o, {-5, -2, 0});
}

TEST(ProjectiveCameras, DifferentialsAreTheNeighbouringRays) {
    const std::string lens = "\"float lensradius\" 0.2 \"float focaldistance\" 3";
    for (const std::string type : {"perspective", "orthographic"})
        for (const std::string& text : {std::string(), lens}) {
            const auto camera =
                MakeCamera(type, text, {40, 30}, AnimatedTransform(Transform::Rotate(30, {1, 1, 0})));
            const Point2 film(7.25f, 21.5f), onLens(0.8f, 0.3f);
            const CameraRay ray = RayAt(*camera, film, onLens);
            const CameraRay right = RayAt(*camera, film + Point2(1, 0), onLens),
                            below = RayAt(*camera, film + Point2(0, 1), onLens);
            ExpectNear(ray.rxOrigin, right.ray.o);
            ExpectNear(ray.rxDirection, right.ray.d);
            ExpectNear(ray.ryOrigin, below.ray.o);
            ExpectNear(ray.ryDirection, below.ray.d);
        }
}

TEST(ProjectiveCameras, LensRaysMeetInThePlaneOfFocus) {
    Rng rng(SeedOf(FullTestName()));
    for (const std::string type : {"perspective", "orthographic"}) {
        const auto pinhole = MakeCamera(type, "");
        const auto camera = MakeCamera(type, "\"float lensradius\" 0.5 \"float focaldistance\" 4");
        const Point2 film(31, 77);
        const Ray central = RayAt(*pinhole, film).ray;
        // A plane, not a sphere: 4 along z.
        const Point3 focus = central(4 / central.d.z);
        double sumSquares = 0;
        constexpr int kRays = 2000;
        for (int i = 0; i < kRays; ++i) {
            const Ray ray = RayAt(*camera, film, rng.Uniform2D()).ray;
            ExpectNear(ray((4 - ray.o.z) / ray.d.z), focus, 1e-5f);
            EXPECT_NEAR(Length(ray.d), 1, 1e-6f);
            const Vec3 offset = ray.o - central.o;
            EXPECT_EQ(offset.z, 0);
            EXPECT_LE(Length(offset), 0.5f + 1e-6f);
            sumSquares += double(LengthSquared(offset));
        }
        // Uniform over the disk: the mean of r^2 is R^2 / 2, its standard deviation R^2 / sqrt(12); five
        // errors.
        EXPECT_NEAR(sumSquares / kRays, 0.125, 5 * 0.25 / std::sqrt(12.0 * kRays));
    }
}

TEST(ProjectiveCameras, TimesFillTheShutterInterval) {
    const auto camera = MakeCamera("perspective", "\"float shutteropen\" 0.5 \"float shutterclose\" 2.5");
    EXPECT_EQ(camera->ShutterOpen(), 0.5f);
    EXPECT_EQ(camera->ShutterClose(), 2.5f);
    for (const float u : {0.f, 0.25f, 0.75f})
        EXPECT_FLOAT_EQ(RayAt(*camera, {1, 1}, Point2(0.5f), u).ray.time, 0.5f + 2 * u);
}

TEST(ProjectiveCameras, MoveWithTheirTransform) {
    const AnimatedTransform moving(Transform(), 0,
                                   Transform::Translate({2, 0, 0}) * Transform::Rotate(90, {0, 1, 0}), 1);
    const auto camera = MakeCamera("perspective", "", {10, 10}, moving);
    const CameraRay middle = RayAt(*camera, {5, 5}, Point2(0.5f), 0.5f);
    ExpectNear(middle.ray.o, {1, 0, 0});
    ExpectNear(middle.ray.d, {std::sqrt(0.5f), 0, std::sqrt(0.5f)});
    ExpectNear(RayAt(*camera, {5, 5}).ray.d, {0, 0, 1});
}

TEST(ProjectiveCameras, DirectionsStayUnitUnderScale) {
    const auto camera =
        MakeCamera("perspective", "", {10, 10}, AnimatedTransform(Transform::Scale({3, 3, -3})));
    for (const Point2 film : {Point2(0, 0), Point2(5, 5), Point2(9, 2)}) {
        const CameraRay ray = RayAt(*camera, film);
        EXPECT_NEAR(Length(ray.ray.d), 1, 1e-6f);
        EXPECT_NEAR(Length(ray.rxDirection), 1, 1e-6f);
        EXPECT_LT(ray.ray.d.z, 0);
    }
}

TEST(ProjectiveCameras, MatricesLeadFromRasterToScreen) {
    for (const std::string type : {"perspective", "orthographic"}) {
        const auto camera = MakeCamera(type, "");
        for (const Point2 film : {Point2(0, 0), Point2(50, 80)}) {
            const Point3 onNearPlane = camera->CameraFromRaster().Point({film.x, film.y, 0});
            const Point3 screen = camera->ScreenFromCamera()->Point(onNearPlane);
            EXPECT_NEAR(screen.x, -2 + 4 * film.x / 200, 1e-4f);
            EXPECT_NEAR(screen.y, 1 - 2 * film.y / 100, 1e-4f);
        }
    }
}

TEST(ProjectiveCameras, MistakesAreSaidWithTheirPlace) {
    struct Case {
        std::string text, part;
    };
    for (const Case& c : {
             Case{"\"float fov\" 0", "fov is 0 degrees; it must lie between 0 and 180"},
             Case{"\"float fov\" 180", "fov is 180 degrees"},
             Case{"\"float fov\" -20", "fov is -20 degrees"},
             Case{"\"float frameaspectratio\" 0", "frameaspectratio is 0; it must be positive"},
             Case{"\"float screenwindow\" [0 1 2]",
                  "screenwindow has 3 values; four are expected: x0 x1 y0 y1"},
             Case{"\"float screenwindow\" [0 1 2 2]", "the screen window is empty"},
             Case{"\"float lensradius\" -1", "lensradius is -1; it must be zero or more"},
             Case{"\"float lensradius\" 1 \"float focaldistance\" 0",
                  "focaldistance is 0; it must be positive"},
             Case{"\"float shutterclose\" 0", "the shutter closes at 0 but opens at 0; it must close later"},
             Case{"\"float shutterclose\" 1 \"float shutteropen\" 3",
                  "the shutter closes at 1 but opens at 3"},
             Case{"\"float fvo\" 40", "fov"},
         }) {
        const std::string error = ErrorOf("perspective", c.text);
        EXPECT_NE(error.find(c.part), std::string::npos) << c.text << " says: " << error;
        EXPECT_NE(error.find("scene.pbrt:1:"), std::string::npos) << error;
    }
    EXPECT_NE(ErrorOf("orthographic", "\"float fov\" 40"), "");
}

TEST(Camera, ReadsTheLensWhereItHasOne) {
    const std::string lens = "\"float lensradius\" 0.1 \"float focaldistance\" 2";
    for (const char* type : {"perspective", "orthographic"}) {
        EXPECT_FALSE(MakeCamera(type, "")->ReadsLens()) << type;
        EXPECT_TRUE(MakeCamera(type, lens)->ReadsLens()) << type;
        // What it says is what it does.
        for (const std::string& text : {std::string(), lens}) {
            const auto camera = MakeCamera(type, text);
            const CameraSample a{{50, 30}, {0.1f, 0.2f}, 0.5f}, b{{50, 30}, {0.8f, 0.4f}, 0.5f};
            EXPECT_EQ(camera->GenerateRay(a)->ray.o != camera->GenerateRay(b)->ray.o, camera->ReadsLens());
        }
    }
    EXPECT_FALSE(MakeCamera("spherical", "")->ReadsLens());
}

}  // namespace
}  // namespace lacquer::projective_test
