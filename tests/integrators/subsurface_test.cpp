// Subsurface scattering as it is rendered: surfaces whose radiance is known.
#include <gtest/gtest.h>

#include "integrators/render_fixtures.h"
#include "pbrt/scattering/bssrdf_table.h"
#include "pbrt/scattering/fresnel.h"

namespace lacquer::test::subsurface_test {
namespace {

constexpr double kAlpha = 1e-4;

/// A large square of the material, seen from above (straight, or at 60 degrees), in white surroundings.
std::string Square(const std::string& material, bool oblique, const std::string& integrator = "volpath") {
    const std::string eye = oblique ? "0 0.8660254 0.5" : "0 0 1";
    return "LookAt " + eye +
           "  0 0 0  1 0 0 Camera \"perspective\" Film \"rgb\" \"integer xresolution\" 4 "
           "\"integer yresolution\" 4 Sampler \"independent\" Integrator \"" +
           integrator + "\" \"integer maxdepth\" 20 WorldBegin LightSource \"infinite\" \"rgb L\" [1 1 1] " +
           material + " Shape \"bilinearmesh\" \"point3 P\" [-10 -10 0  10 -10 0  -10 10 0  10 10 0]";
}

/// Mean free path 0.01, albedo 0.98.
const std::string kMedium =
    "Material \"subsurface\" \"spectrum sigma_a\" [300 2 900 2] \"spectrum sigma_s\" [300 98 900 98] ";

/// What the square sends to the camera: the reflected part, and what is let in, comes out again (but for the
/// 0.1 % that the probes do not draw), and is let out in that direction.
double ExpectedRadiance(double cosTheta, float eta, float share) {
    const double reflected = double(FresnelDielectric(float(cosTheta), eta));
    return reflected + (1 - reflected) * 0.999 * double(share);
}

// The exit's normalisation is a polynomial, off by up to 0.5 %. Power: the standard errors are about 1 %, for
// half of the probes miss; a lost eta^2 (43 %), a probe axis left out (25 % and more) or one hit of two are
// found.
TEST(Subsurface, AFlatSurfaceSendsBackItsEffectiveAlbedo) {
    for (const float eta : {1.f, 1.33f})
        for (const bool oblique : {false, true}) {
            const RenderSetup setup =
                BuildText(Square(kMedium + "\"float eta\" " + std::to_string(eta), oblique));
            const float share = BssrdfSlice(*BssrdfTable::Shared(0, eta), 0.98f).EffectiveAlbedo();
            const double expected = ExpectedRadiance(oblique ? 0.5 : 1, eta, share);
            EXPECT_TRUE(Passes(FullTestName() + std::to_string(eta) + (oblique ? "oblique" : "straight"),
                               kAlpha, [&](uint64_t seed) {
                                   return ZTest(CenterRadiance(setup, 8000, seed), expected, 6e-3,
                                                "radiance");
                               }));
        }
}

// A distant light at 45 degrees: only light samples find it.
TEST(Subsurface, LightIsSampledAtTheExit) {
    std::string scene = Square(kMedium, true);
    const std::string infinite = "\"infinite\" \"rgb L\" [1 1 1]";
    scene.replace(scene.find(infinite), infinite.size(),
                  "\"distant\" \"rgb L\" [1 1 1] \"point3 from\" [-1 0 1] \"point3 to\" [0 0 0]");
    const RenderSetup setup = BuildText(scene);
    const double share = double(BssrdfSlice(*BssrdfTable::Shared(0, 1.33f), 0.98f).EffectiveAlbedo());
    const double cosTheta_i = std::sqrt(0.5);
    const double letIn = 1 - double(FresnelDielectric(0.5f, 1.33f));
    const double letOut = (1 - double(FresnelDielectric(float(cosTheta_i), 1.33f))) /
                          double(Pi * (1 - 2 * FresnelMoment1(1 / 1.33f)));
    EXPECT_TRUE(Passes(FullTestName(), kAlpha, [&](uint64_t seed) {
        return ZTest(CenterRadiance(setup, 8000, seed), letIn * 0.999 * share * letOut * cosTheta_i, 1e-4,
                     "radiance");
    }));
}

TEST(SubsurfaceControl, AnAlbedoOffByTenPercentIsFound) {
    const RenderSetup setup = BuildText(Square(kMedium, false));
    const float share = BssrdfSlice(*BssrdfTable::Shared(0, 1.33f), 0.98f).EffectiveAlbedo();
    EXPECT_LT(ZTest(CenterRadiance(setup, 8000, SeedOf(FullTestName())),
                    ExpectedRadiance(1, 1.33f, 0.9f * share), 6e-3, "radiance")
                  .pValue,
              kAlpha);
}

// The given reflectance is that of the light let in.
TEST(Subsurface, ReflectanceIsWhatComesOut) {
    const RenderSetup setup =
        BuildText(Square("Material \"subsurface\" \"spectrum reflectance\" [300 0.6 900 0.6] \"float eta\" 1 "
                         "\"float scale\" 0.01 ",
                         false));
    EXPECT_TRUE(Passes(FullTestName(), kAlpha, [&](uint64_t seed) {
        return ZTest(CenterRadiance(setup, 8000, seed), ExpectedRadiance(1, 1, 0.6f), 4e-3, "radiance");
    }));
}

// A medium so dense that no position tells entry from exit is a diffuse surface, not a black one.
TEST(Subsurface, DenseMediaLetLightOutWhereItEnters) {
    const RenderSetup setup = BuildText(Square(kMedium + "\"float scale\" 1e9 \"float eta\" 1", false));
    const float share = BssrdfSlice(*BssrdfTable::Shared(0, 1), 0.98f).EffectiveAlbedo();
    EXPECT_TRUE(Passes(FullTestName(), kAlpha, [&](uint64_t seed) {
        return ZTest(CenterRadiance(setup, 3000, seed), double(share), 4e-3, "radiance");
    }));
}

// The medium is that of one material: what stands in it, or touches it, lets nothing out.
TEST(Subsurface, ExitsAreOnSurfacesOfTheSameMaterialOnly) {
    const std::string under =
        " Material \"diffuse\" \"rgb reflectance\" [0 0 0] Shape \"bilinearmesh\" \"point3 P\" "
        "[-10 -10 -0.001  10 -10 -0.001  -10 10 -0.001  10 10 -0.001]";
    const std::string scene = Square(kMedium, false);
    const RenderSetup alone = BuildText(scene), with = BuildText(scene + under);
    const RunningMean a = CenterRadiance(alone, 3000, SeedOf(FullTestName()));
    const RunningMean b = CenterRadiance(with, 3000, SeedOf(FullTestName()));
    EXPECT_NEAR(a.Mean(), b.Mean(), 5 * (a.StandardError() + b.StandardError()));
}

// Half of all hits are black: light comes in at half of the places, and goes out at half of them.
TEST(Subsurface, AMixtureIsEnteredAndLeftWhereItIsChosen) {
    const RenderSetup setup = BuildText(
        Square("MakeNamedMaterial \"black\" \"string type\" \"diffuse\" \"rgb reflectance\" [0 0 0] "
               "MakeNamedMaterial \"deep\" \"string type\" \"subsurface\" \"float eta\" 1 "
               "\"spectrum sigma_a\" [300 2 900 2] \"spectrum sigma_s\" [300 98 900 98] "
               "Material \"mix\" \"string materials\" [\"black\" \"deep\"] \"float amount\" 0.5 ",
               false, "volpath"));
    const float share = BssrdfSlice(*BssrdfTable::Shared(0, 1), 0.98f).EffectiveAlbedo();
    // The camera's ray is the same every time: one draw of the mixture.
    const RunningMean mean = CenterRadiance(setup, 8000, SeedOf(FullTestName()));
    const double expected = mean.Mean() > 0 ? 0.999 * double(share) / 2 : 0;
    EXPECT_GT(ZTest(mean, expected, 6e-3, "radiance").pValue, kAlpha);
}

// "path" knows the boundary only, as in pbrt: light passes through.
TEST(Subsurface, PathTakesTheBoundaryOnly) {
    const RenderSetup setup = BuildText(Square(kMedium + "\"float eta\" 1", false, "path"));
    EXPECT_NEAR(CenterRadiance(setup, 100, 1).Mean(), 1, 1e-4);
}

}  // namespace
}  // namespace lacquer::test::subsurface_test
