#include "pbrt/lights/emission.h"
#include "light_fixtures.h"

namespace lacquer::test::emission_test {
namespace {

double LuminanceOfPoint(std::vector<Parameter> parameters) {
    const auto light = MakeLight("point", std::move(parameters));
    return LuminanceOf([&](const SampledWavelengths& lambda) {
        return light->SampleLi(LightReference(Point3(1, 0, 0)), Point2(0.5f), lambda)->L;
    });
}

// Sums of 471 floats: a relative error of some 1e-6; 1e-4 leaves room for the colour space's own rounding.
constexpr double kTolerance = 1e-4;

TEST(Emission, DefaultIsTheWhiteOfUnitLuminance) { EXPECT_NEAR(LuminanceOfPoint({}), 1, kTolerance); }

TEST(Emission, MagnitudeOfSpectraCancels) {
    EXPECT_NEAR(LuminanceOfPoint({FloatParam("I", {300, 5, 900, 5}, "spectrum")}), 1, kTolerance);
    EXPECT_NEAR(LuminanceOfPoint({FloatParam("I", {300, 70, 900, 70}, "spectrum")}), 1, kTolerance);
    EXPECT_NEAR(LuminanceOfPoint({FloatParam("I", {3000}, "blackbody"), FloatParam("scale", {2.5f})}), 2.5,
                3e-4);
}

TEST(Emission, MagnitudeOfRgbMatters) {
    EXPECT_NEAR(LuminanceOfPoint({FloatParam("I", {1, 1, 1}, "rgb")}), 1, kTolerance);
    EXPECT_NEAR(LuminanceOfPoint({FloatParam("I", {2, 2, 2}, "rgb")}), 2, 2 * kTolerance);
    // Luminance of sRGB's red is .2126; the fitted spectra are within a few thousandths of their colour.
    EXPECT_NEAR(LuminanceOfPoint({FloatParam("I", {1, 0, 0}, "rgb")}), 0.2126, 5e-3);
}

// A million lights with a table each would take 2 GB.
TEST(Emission, EqualSpectraShareATableAndColoursHaveNone) {
    const auto emissionOf = [](const Parameter& I, float scale) {
        return ReadEmission(MakeParams({I}), "I", scale);
    };
    const Parameter warm = FloatParam("I", {3000}, "blackbody"), cold = FloatParam("I", {9000}, "blackbody");
    const Emission first = emissionOf(warm, 1), second = emissionOf(warm, 7);
    EXPECT_EQ(first.spectrum, second.spectrum);
    EXPECT_NEAR(second.luminance, 7 * first.luminance, 1e-5f * second.luminance);
    EXPECT_NE(first.spectrum, emissionOf(cold, 1).spectrum);
    const std::weak_ptr<const Spectrum> unused = emissionOf(cold, 1).spectrum;
    EXPECT_TRUE(unused.expired()) << "a table outlives its lights";

    const Emission color = emissionOf(FloatParam("I", {0.8f, 0.4f, 0.2f}, "rgb"), 2);
    EXPECT_EQ(dynamic_cast<const DenselySampledSpectrum*>(color.spectrum.get()), nullptr);
    const DenselySampledSpectrum table(*color.spectrum);
    for (float u = 0; u < 1; u += 0.01f) {
        const auto lambda = SampledWavelengths::SampleVisible(u);
        for (int i = 0; i < kNumWavelengths; ++i) {
            const float expected = color.scale * table.Evaluate(lambda[i]);
            EXPECT_NEAR(color.Sample(lambda)[i], expected, 0.01f * expected) << lambda[i] << " nm";
        }
    }
}

TEST(Emission, LuminanceIsThatOfTheTripleOrOne) {
    EXPECT_NEAR(EmissionLuminance(MakeParams({FloatParam("L", {0, 1, 0}, "rgb")}), "L"), 0.7152f, 1e-3f);
    EXPECT_EQ(EmissionLuminance(MakeParams({FloatParam("L", {5000}, "blackbody")}), "L"), 1.f);
    EXPECT_EQ(EmissionLuminance(MakeParams({}), "L"), 1.f);
}

TEST(Emission, SpectrumWithoutLuminanceIsAnError) {
    EXPECT_THROW(LuminanceOfPoint({FloatParam("I", {300, 1, 350, 1}, "spectrum")}), SceneError);
    EXPECT_THROW(LuminanceOfPoint({FloatParam("I", {400, 0, 700, 0}, "spectrum")}), SceneError);
}

TEST(Emission, ScaleMustBeFiniteAndNotNegative) {
    for (const float bad : {-1.f, NAN, Infinity})
        for (const char* type : {"point", "spot", "distant", "infinite"})
            EXPECT_THROW(MakeLight(type, {FloatParam("scale", {bad})}), SceneError) << type << " " << bad;
}

TEST(Emission, SingularTransformIsAnError) {
    const Transform flat(glm::mat4(0.f), glm::mat4(0.f));
    for (const char* type : {"point", "spot", "distant"})
        EXPECT_THROW(MakeLight(type, {}, flat), SceneError) << type;
    const Parameter portal = FloatParam("portal", {0, 0, 0, 0, 1, 0, 1, 1, 0, 1, 0, 0}, "point3");
    EXPECT_THROW(MakeLight("infinite", {portal}, flat), SceneError);
    // A uniform light from everywhere has no place.
    EXPECT_NO_THROW(MakeLight("infinite", {}, flat));
}

}  // namespace
}  // namespace lacquer::test::emission_test
