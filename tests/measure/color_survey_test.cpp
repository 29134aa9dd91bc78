#include "measure/color_survey.h"

#include <gtest/gtest.h>

#include "measure/scene_material.h"
#include "pbrt/scattering/fresnel.h"
#include "pbrt/scene/parser.h"

namespace lacquer::measure::color_survey_test {
namespace {

enum Geometry : size_t { kRing, kIncluded, kExcluded, kAs15, kAs25, kAs45, kAs75, kAs110 };
enum Illuminant : size_t { kD50, kD65, kA };

ColorSurvey ColorsOf(const std::string& material, int samples = 4096, uint64_t seed = 1) {
    const SceneMaterial made =
        LoadMaterial(ParseText("WorldBegin " + material, "scene.pbrt", "", nullptr), "m", Point2(0.5f));
    const std::vector<float> wavelengths = ColorWavelengths(made.bsdf->IsStochastic());
    const SpectralSubject subject(*made.setup.material, Point2(0.5f), wavelengths, {});
    return SurveyColors(subject, wavelengths, {.samples = samples, .seed = seed}, nullptr);
}
std::string Named(const std::string& name, const std::string& rest) {
    return "MakeNamedMaterial \"" + name + "\" \"string type\" " + rest + " ";
}

TEST(ColorSurvey, DiffuserHasTheWhitesOfTheIlluminants) {
    const ColorSurvey white = ColorsOf(Named("m", "\"diffuse\" \"spectrum reflectance\" [360 1 830 1]"));
    // CIE 15:2004, table T.3, for the observer of 1931.
    const double expected[3][3] = {{96.42, 100, 82.51}, {95.04, 100, 108.88}, {109.85, 100, 35.58}};
    for (size_t i = 0; i < kIlluminants.size(); ++i)
        for (size_t g = 0; g < ColorGeometries().size(); ++g) {
            const ColorReading r = white.At(g, i);
            for (size_t k = 0; k < 3; ++k)
                EXPECT_NEAR(r.xyz[k].value, expected[i][k], g == kExcluded ? 1.2 : 0.04) << i << ' ' << k;
            if (g == kExcluded) continue;
            EXPECT_NEAR(r.L.value, 100, 1e-3);
            EXPECT_NEAR(r.chroma.value, 0, 1e-3);
        }
    // The gloss trap takes away what it covers of the hemisphere: sin^2 of its half angle, times a cosine.
    const double trap = Sqr(std::sin(kTrapDeg * 3.14159265 / 180)) * std::cos(8 * 3.14159265 / 180);
    EXPECT_NEAR(white.At(kExcluded, kD65).xyz[1].value, 100 * (1 - trap), 0.15);
}

TEST(ColorSurvey, GreyIsAsDarkAsItIs) {
    const ColorSurvey grey =
        ColorsOf(Named("m", "\"diffuse\" \"spectrum reflectance\" [360 0.184187 830 0.184187]"));
    for (const size_t g : {size_t(kRing), size_t(kAs15), size_t(kAs110)})
        EXPECT_NEAR(grey.At(g, kD50).L.value, 50, 1e-3);
}

// sRGB's red of 8 bits, whose L*a*b* under D65 is known; under A it is another.
TEST(ColorSurvey, ColorsOfRGB) {
    const ColorSurvey red = ColorsOf(Named("m", "\"diffuse\" \"rgb reflectance\" [0.6 0.1 0.05]"));
    const glm::dvec3 xyz = 100.0 * glm::dvec3(ColorSpace::SRGB().ToXYZ(RGB(0.6f, 0.1f, 0.05f)));
    const Lab expected = LabOf(xyz, {95.047, 100, 108.883});
    const ColorReading d65 = red.At(kRing, kD65);
    EXPECT_NEAR(d65.L.value, expected.L, 0.1);
    EXPECT_NEAR(d65.a.value, expected.a, 0.3);
    EXPECT_NEAR(d65.b.value, expected.b, 0.3);
    EXPECT_NEAR(d65.hueDeg.value, expected.HueDegrees(), 0.3);
    EXPECT_GT(red.At(kRing, kA).L.value, d65.L.value + 2);
}

TEST(ColorSurvey, MirrorsAreSeenBySpheresWithoutTrapsAlone) {
    const ColorSurvey mirror =
        ColorsOf(Named("m", "\"conductor\" \"spectrum eta\" [360 1.5 830 1.5] \"spectrum k\" [360 3 830 3]"));
    const float c = std::cos(8 * 3.14159265f / 180);
    EXPECT_NEAR(mirror.At(kIncluded, kD65).xyz[1].value,
                100 * double(FresnelConductor(c, SampledSpectrum(1.5f), SampledSpectrum(3))[0]), 1e-3);
    for (const size_t g : {size_t(kRing), size_t(kExcluded), size_t(kAs15), size_t(kAs110)})
        EXPECT_EQ(mirror.At(g, kD65).xyz[1].value, 0);
}

TEST(ColorSurvey, FlopsOfMetalsFall) {
    const ColorSurvey metal = ColorsOf(Named("m", "\"conductor\" \"float roughness\" 0.15"));
    double before = 1e9;
    for (const size_t g : {size_t(kAs15), size_t(kAs25), size_t(kAs45), size_t(kAs75), size_t(kAs110)}) {
        const double L = metal.At(g, kD65).L.value;
        EXPECT_LT(L, before) << g;
        before = L;
    }
}

// Two estimators of one coat: differences are as large as their errors say, and see a change of the coat.
TEST(ColorSurvey, NoisyModelsKnowTheirErrors) {
    const auto coat = [](const char* estimator, const char* color) {
        return ColorsOf(
            Named("m", std::string("\"coateddiffuse\" \"float roughness\" 0.2 \"rgb reflectance\" [") +
                           color + "] \"string estimator\" \"" + estimator + "\""),
            4096, Hash(uint64_t(estimator[0])));
    };
    const ColorSurvey closed = coat("auto", "0.1 0.3 0.5"), walks = coat("unidirectional", "0.1 0.3 0.5");
    const ColorSurvey other = coat("unidirectional", "0.1 0.33 0.5");
    for (const size_t g : {size_t(kRing), size_t(kIncluded), size_t(kAs45), size_t(kAs75)}) {
        const ColorReading a = closed.At(g, kD65), b = walks.At(g, kD65);
        EXPECT_GT(b.L.error, 0) << g;
        EXPECT_LT(std::abs(a.L.value - b.L.value), 5 * std::hypot(a.L.error, b.L.error) + 0.02) << g;
        const Uncertain same = ColorSurvey::Difference(closed, walks, g, kD65),
                        differs = ColorSurvey::Difference(closed, other, g, kD65);
        EXPECT_LT(same.value, 5 * same.error + 0.03) << g;
        EXPECT_GT(differs.value, 5 * differs.error) << g;
    }
}

TEST(ColorSurvey, IsTheSameForTheSameSeed) {
    const std::string rough =
        Named("m", "\"coateddiffuse\" \"float roughness\" 0.2 \"string estimator\" \"unidirectional\"");
    const auto value = [&](uint64_t seed) { return ColorsOf(rough, 512, seed).At(kRing, kD65).xyz[1].value; };
    EXPECT_EQ(value(3), value(3));
    EXPECT_NE(value(3), value(4));
}

}  // namespace
}  // namespace lacquer::measure::color_survey_test
