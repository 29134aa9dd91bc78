// Lights from one point or one direction: point, spot, distant.
#include "light_fixtures.h"

namespace lacquer::test::point_like_test {
namespace {

/// Luminance of what arrives at p, 0 if nothing does.
double At(const Light& light, Point3 p) {
    const auto sample = light.SampleLi(LightReference(p), Point2(0.5f), Wavelengths());
    return sample ? double(sample->L[0]) / WhiteAt(Wavelengths()) : 0;
}

TEST(PointLight, FollowsTheInverseSquareLaw) {
    const auto light = MakeLight("point", {FloatParam("from", {1, 2, 3}, "point3")});
    for (const float d : {0.5f, 1.f, 4.f, 1000.f})
        EXPECT_NEAR(At(*light, {1, 2, 3 + d}) * double(d * d), 1, 1e-5);
    EXPECT_FALSE(light->SampleLi(LightReference(Point3(1, 2, 3)), Point2(0), Wavelengths()));
    const auto sample = light->SampleLi(LightReference(Point3(1, 2, 5)), Point2(0), Wavelengths());
    EXPECT_EQ(sample->wi, Vec3(0, 0, -1));
    EXPECT_EQ(sample->pdf, 1.f);
}

TEST(PointLight, EmitsTheGivenPower) {
    const auto light = MakeLight("point", {FloatParam("power", {50}), FloatParam("I", {4000}, "blackbody")});
    EXPECT_NEAR(light->Power(), 50, 1e-3);
    const double intensity = LuminanceOf([&](const SampledWavelengths& lambda) {
        return light->SampleLi(LightReference(Point3(1, 0, 0)), Point2(0.5f), lambda)->L;
    });
    EXPECT_NEAR(4 * double(Pi) * intensity, 50, 5e-3);
}

TEST(PointLight, PowerOfZeroMeansNotGiven) {
    EXPECT_NEAR(At(*MakeLight("point", {FloatParam("power", {0})}), {1, 0, 0}), 1, 1e-5);
    EXPECT_NEAR(At(*MakeLight("point", {FloatParam("power", {-3})}), {1, 0, 0}), 1, 1e-5);
    EXPECT_THROW(MakeLight("point", {FloatParam("power", {NAN})}), SceneError);
}

TEST(PointLight, ScaleOfTheTransformMovesOnly) {
    const auto light =
        MakeLight("point", {FloatParam("from", {1, 0, 0}, "point3")}, Transform::Scale(Vec3(5)));
    EXPECT_NEAR(At(*light, {5, 0, 1}), 1, 1e-5);
}

/// Integral of the intensity of a light at the origin over the cone about +z, Simpson's rule in the cosine.
double FluxInCone(const Light& light, double coneDeg) {
    constexpr int kSteps = 20000;
    const double low = std::cos(coneDeg * double(Pi) / 180);
    double sum = 0;
    for (int i = 0; i <= kSteps; ++i) {
        const double cosTheta = low + (1 - low) * i / kSteps;
        const Vec3 w(float(std::sqrt(std::max(0., 1 - cosTheta * cosTheta))), 0, float(cosTheta));
        sum += At(light, w) * (i == 0 || i == kSteps ? 1 : i % 2 ? 4 : 2);
    }
    return 2 * double(Pi) * sum * ((1 - low) / kSteps) / 3;
}

TEST(SpotLight, EmitsTheGivenPower) {
    for (const float cone : {1.f, 30.f, 90.f, 150.f, 180.f})
        for (const float delta : {0.5f, 1.f}) {
            const auto light = MakeLight("spot", {FloatParam("power", {20}), FloatParam("coneangle", {cone}),
                                                  FloatParam("conedeltaangle", {delta * cone})});
            // A cone of one degree spans 1.5e-4 in its cosine, of which a float resolves one part in 2500.
            EXPECT_NEAR(FluxInCone(*light, double(cone)), 20, cone < 2 ? 0.02 : 2e-3) << cone;
            EXPECT_NEAR(light->Power(), 20, 1e-3);
        }
}

TEST(SpotLight, FallsOffBetweenTheTwoAngles) {
    const auto light =
        MakeLight("spot", {FloatParam("coneangle", {40}), FloatParam("conedeltaangle", {20}),
                           FloatParam("from", {0, 0, 0}, "point3"), FloatParam("to", {3, 0, 0}, "point3")});
    const auto at = [&](float deg) {
        return At(*light, {std::cos(Radians(deg)), std::sin(Radians(deg)), 0});
    };
    EXPECT_NEAR(at(0), 1, 1e-5);
    EXPECT_NEAR(at(19.9f), 1, 1e-5);
    EXPECT_EQ(at(40.1f), 0);
    EXPECT_EQ(at(170), 0);
    const double t = (std::cos(30 * double(Pi) / 180) - std::cos(40 * double(Pi) / 180)) /
                     (std::cos(20 * double(Pi) / 180) - std::cos(40 * double(Pi) / 180));
    EXPECT_NEAR(at(30), t * t * (3 - 2 * t), 1e-5);
}

TEST(SpotLight, FollowsItsTransform) {
    const auto light = MakeLight(
        "spot", {},
        Transform::Translate({0, 10, 0}) * Transform::Rotate(90, {1, 0, 0}) * Transform::Scale(Vec3(3)));
    // +z turned by 90 degrees about x is -y.
    EXPECT_NEAR(At(*light, {0, 8, 0}), 0.25, 1e-5);
    EXPECT_EQ(At(*light, {0, 12, 0}), 0);
}

TEST(SpotLight, RejectsDegenerateCones) {
    for (const float bad : {0.f, -5.f, 181.f, NAN, Infinity})
        EXPECT_THROW(MakeLight("spot", {FloatParam("coneangle", {bad})}), SceneError) << bad;
    EXPECT_THROW(MakeLight("spot", {FloatParam("conedeltaangle", {-1})}), SceneError);
    EXPECT_THROW(MakeLight("spot", {FloatParam("to", {0, 0, 0}, "point3")}), SceneError);
    EXPECT_THROW(MakeLight("spot", {FloatParam("to", {0, 0, NAN}, "point3")}), SceneError);
    // A fall-off much wider than the cone leaves a hard rim.
    const auto hard = MakeLight("spot", {FloatParam("coneangle", {2}), FloatParam("conedeltaangle", {90})});
    EXPECT_NEAR(At(*hard, {0, 0, 1}), 1, 1e-5);
    EXPECT_EQ(At(*hard, {0.1f, 0, 1}), 0);
}

TEST(DistantLight, IlluminanceIsTheIrradianceOfAFacingSurface) {
    const auto light =
        MakeLight("distant", {FloatParam("illuminance", {3}), FloatParam("from", {0, 5, 0}, "point3"),
                              FloatParam("to", {0, 0, 0}, "point3")});
    const auto sample = light->SampleLi(LightReference(Point3(7)), Point2(0), Wavelengths());
    ASSERT_TRUE(sample);
    EXPECT_NEAR(At(*light, Point3(7)), 3, 1e-5);
    EXPECT_NEAR(Length(sample->wi - Vec3(0, 1, 0)), 0, 1e-6);
    EXPECT_EQ(sample->pdf, 1.f);
    EXPECT_EQ(light->PdfLi(LightReference(Point3(7)), sample->wi, nullptr), 0.f);
}

TEST(DistantLight, SamplesLieOutsideOfTheScene) {
    const auto light = MakeLight("distant", {});
    const Bounds3 scene({-100, -100, -100}, {100, 100, 100});
    light->Preprocess(scene);
    const auto sample = light->SampleLi(LightReference(Point3(100, 100, 100)), Point2(0), Wavelengths());
    EXPECT_FALSE(scene.Contains(sample->p));
    EXPECT_TRUE(IsFinite(sample->p));
}

TEST(DistantLight, RejectsEqualPoints) {
    EXPECT_THROW(MakeLight("distant", {FloatParam("to", {0, 0, 0}, "point3")}), SceneError);
}

}  // namespace
}  // namespace lacquer::test::point_like_test
