// The way back: from points of the scene to the film.
#include <gtest/gtest.h>

#include "pbrt/base/camera.h"
#include "pbrt/core/rng.h"
#include "support/scene_parts.h"
#include "support/statistics.h"

namespace lacquer::importance_test {
namespace {

constexpr Int2 kResolution(200, 100);

std::unique_ptr<Camera> MakeCamera(const std::string& type, const std::string& text,
                                   const AnimatedTransform& renderFromCamera = {}) {
    const Params params = test::ParamsFromText("camera", text);
    return Registry<CameraKind>::Find(type)({params, renderFromCamera, kResolution});
}
struct CameraCase {
    std::string name;
    std::unique_ptr<Camera> camera;
};
std::vector<CameraCase> Cameras() {
    const Transform turned = Transform::Translate({1, 2, 3}) * Transform::Rotate(40, {1, 2, 3});
    const AnimatedTransform still(turned);
    const AnimatedTransform mirrored(turned * Transform::Scale({-2, 2, 2}));
    const AnimatedTransform moving(turned, 0, Transform::Rotate(30, {0, 1, 0}), 1);
    const std::string lens = "\"float lensradius\" 0.2 \"float focaldistance\" 3 ";
    std::vector<CameraCase> cases;
    cases.push_back({"pinhole", MakeCamera("perspective", "\"float fov\" 50", still)});
    cases.push_back({"lens", MakeCamera("perspective", lens + "\"float fov\" 70", still)});
    cases.push_back({"mirrored", MakeCamera("perspective", lens, mirrored)});
    cases.push_back({"moving", MakeCamera("perspective", lens, moving)});
    cases.push_back(
        {"window", MakeCamera("perspective", lens + "\"float screenwindow\" [-0.2 0.9 0.1 0.7]", still)});
    return cases;
}

TEST(CameraImportance, ARayThroughThePointFoundMeetsTheScenePoint) {
    for (const CameraCase& c : Cameras()) {
        Rng rng(test::SeedOf(c.name));
        for (int i = 0; i < 200; ++i) {
            const Point2 film(200 * rng.Uniform(), 100 * rng.Uniform()), lens(rng.Uniform(), rng.Uniform());
            const float time = rng.Uniform(), distance = 0.5f + 5 * rng.Uniform();
            const CameraRay ray = c.camera->GenerateRay({film, lens, time}).value();
            const auto back = c.camera->SampleWi(ray.ray(distance), ray.ray.time, lens);
            ASSERT_TRUE(back) << c.name;
            EXPECT_LT(Length(back->p - ray.ray.o), 1e-5f) << c.name;
            EXPECT_LT(Length(back->wi + ray.ray.d), 1e-5f) << c.name;
            EXPECT_LT(glm::length(back->pFilm - film), 0.02f) << c.name;
        }
    }
}

// The density of directions is the number of film positions per solid angle, by finite differences; the
// importance is that density over cosine and lens area.
TEST(CameraImportance, DensitiesAreThoseOfCameraRays) {
    for (const CameraCase& c : Cameras()) {
        Rng rng(test::SeedOf(c.name));
        const Vec3 axis = c.camera->GenerateRay({Point2(kResolution) / 2.f, Point2(0.5f), 0}).value().ray.d;
        for (int i = 0; i < 50; ++i) {
            const Point2 film(200 * rng.Uniform(), 100 * rng.Uniform()), lens(rng.Uniform(), rng.Uniform());
            const auto direction = [&](Point2 p) { return c.camera->GenerateRay({p, lens, 0}).value().ray; };
            const Ray ray = direction(film);
            const Vec3 dx = direction(film + Point2(1, 0)).d - direction(film - Point2(1, 0)).d;
            const Vec3 dy = direction(film + Point2(0, 1)).d - direction(film - Point2(0, 1)).d;
            const float perPixel = Length(Cross(dx, dy)) / 4;
            const float pdf = c.camera->PdfWe(ray);
            EXPECT_NEAR(pdf * perPixel * 20000, 1, 2e-3f) << c.name;

            const auto back = c.camera->SampleWi(ray(2), ray.time, lens);
            ASSERT_TRUE(back);
            // W = pdf / (cos lens), and the lens point has the density d^2 / (cos lens), with d = 2.
            EXPECT_NEAR(back->importance / back->pdf, pdf / 4, 2e-3f * pdf / 4) << c.name;
        }
        EXPECT_EQ(c.camera->PdfWe({Point3(0), -axis, 0}), 0) << c.name;
        EXPECT_FALSE(c.camera->SampleWi(Point3(1, 2, 3) - 50.f * axis, 0, Point2(0.5f))) << c.name;
    }
}

TEST(CameraImportance, IsKnownWhereAnglesAreKept) {
    for (const CameraCase& c : Cameras()) EXPECT_EQ(c.camera->WhyNoImportance(), "") << c.name;
    const AnimatedTransform squeezed(Transform::Scale({1, 2, 1}));
    EXPECT_NE(MakeCamera("perspective", "", squeezed)->WhyNoImportance().find("angles"), std::string::npos);
    for (const std::string type : {"orthographic", "spherical"})
        EXPECT_NE(MakeCamera(type, "")->WhyNoImportance().find("perspective"), std::string::npos);
}

}  // namespace
}  // namespace lacquer::importance_test
