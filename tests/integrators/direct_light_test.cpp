// Reflected radiance of a diffuse plane z = 0 under one light, against closed forms.
#include <gtest/gtest.h>

#include "integrators/render_fixtures.h"

namespace lacquer::direct_light_test {
namespace {

using test::BuildText;
using test::CenterRadiance;
using test::FullTestName;
using test::Passes;

constexpr double kPi = 3.14159265358979;
constexpr double kAlbedo = 0.6;

/// The camera looks down at the origin along a slanted line; only that point matters.
RenderSetup PlaneUnder(const std::string& light, const std::string& integrator,
                       const std::string& more = "") {
    return BuildText(
        "LookAt 4 3 1  0 0 0  0 0 1 Camera \"perspective\" Film \"rgb\" \"integer xresolution\" 4 "
        "\"integer yresolution\" 4 Sampler \"independent\" Integrator \"" +
        integrator + "\" \"integer maxdepth\" 1 " + more + " WorldBegin AttributeBegin " + light +
        " AttributeEnd Material \"diffuse\" \"rgb reflectance\" [0.6 0.6 0.6] Shape \"bilinearmesh\" "
        "\"point3 P\" "
        "[-50 -50 0  50 -50 0  -50 50 0  50 50 0] ");
}

TEST(DirectLight, OfDeltaLightsIsExact) {
    struct Case {
        std::string light;
        double irradiance;
    };
    const double smooth = [] {  // the spot's fall-off at 30 degrees, between 25 and 40
        const double a = std::cos(40 * kPi / 180), b = std::cos(25 * kPi / 180),
                     t = (std::cos(30 * kPi / 180) - a) / (b - a);
        return t * t * (3 - 2 * t);
    }();
    const std::vector<Case> cases = {
        {"LightSource \"point\" \"rgb I\" [7 7 7] \"point3 from\" [0 0 2]", 7 / 4.0},
        // cos / d^2 with d = 5, cos = 4/5.
        {"LightSource \"point\" \"rgb I\" [7 7 7] \"point3 from\" [3 0 4]", 7 * 0.8 / 25},
        {"Translate 3 0 0 LightSource \"point\" \"rgb I\" [7 7 7] \"float scale\" 2 \"point3 from\" [0 0 4]",
         14 * 0.8 / 25},
        {"LightSource \"point\" \"rgb I\" [1 1 1] \"float power\" 100 \"point3 from\" [0 0 1]",
         100 / (4 * kPi)},
        {"LightSource \"distant\" \"rgb L\" [3 3 3] \"point3 from\" [0 0 1] \"point3 to\" [0 0 0]", 3},
        {"LightSource \"distant\" \"rgb L\" [3 3 3] \"point3 from\" [0 3 4] \"point3 to\" [0 0 0]", 3 * 0.8},
        {"LightSource \"distant\" \"float illuminance\" 5 \"point3 from\" [0 3 4] \"point3 to\" [0 0 0]",
         5 * 0.8},
        {"LightSource \"spot\" \"rgb I\" [7 7 7] \"point3 from\" [3 0 4] \"point3 to\" [0 0 0]",
         7 * 0.8 / 25},
        // The plane's origin seen 30 degrees off the axis, straight above it.
        {"LightSource \"spot\" \"rgb I\" [7 7 7] \"float coneangle\" 40 \"float conedeltaangle\" 15 \"point3 "
         "from\" [0 0 2] "
         "\"point3 to\" [1.1547005 0 0]",
         7 / 4.0 * smooth},
        {"LightSource \"spot\" \"rgb I\" [7 7 7] \"float coneangle\" 20 \"point3 from\" [0 0 2] \"point3 "
         "to\" [1.1547005 0 0]",
         0},
        // From below the plane, nothing.
        {"LightSource \"point\" \"rgb I\" [7 7 7] \"point3 from\" [0 0 -2]", 0},
    };
    for (const Case& c : cases)
        for (const std::string integrator : {"path", "volpath", "simplepath"}) {
            const auto mean = CenterRadiance(PlaneUnder(c.light, integrator), 20);
            const double expected = kAlbedo / kPi * c.irradiance;
            // Float geometry; the smooth step of nearly equal cosines loses a digit.
            EXPECT_NEAR(mean.Mean(), expected, 3e-5 * expected + 1e-9) << integrator << " " << c.light;
            EXPECT_LT(mean.Variance(), 1e-8 * (1 + expected * expected));
        }
}

// Power: standard errors are 0.2 % of the mean or less (path, simplepath) and 2 % (randomwalk, disk): a
// factor of 2, pi or the cosine shows in all of them, a 2 % error in the first two.
TEST(DirectLight, OfAreaLightsIsTheirProjectedSolidAngle) {
    struct Case {
        std::string light;
        double irradiance;
    };
    const std::vector<Case> cases = {
        // A disk of radius 2 at height 3, facing down: pi L sin^2 of its half angle.
        {"AreaLightSource \"diffuse\" \"rgb L\" [4 4 4] Translate 0 0 3 Rotate 180 1 0 0 Shape \"disk\" "
         "\"float radius\" 2",
         kPi * 4 * 4.0 / 13},
        // A sphere of radius 1 at (3, 0, 4): pi L (r/d)^2 cos.
        {"AreaLightSource \"diffuse\" \"rgb L\" [4 4 4] Translate 3 0 4 Shape \"sphere\"",
         kPi * 4 / 25 * 0.8},
        // A square of side 2 at height 1: four corners of side 1, each (a/sqrt(1+a^2)) atan(b/sqrt(1+a^2)),
        // times L.
        {"AreaLightSource \"diffuse\" \"rgb L\" [4 4 4] \"bool twosided\" true Shape \"bilinearmesh\" "
         "\"point3 P\" "
         "[-1 -1 1  1 -1 1  -1 1 1  1 1 1]",
         4 * 4 * std::sqrt(0.5) * std::atan(std::sqrt(0.5))},
        {"AreaLightSource \"diffuse\" \"rgb L\" [4 4 4] \"bool twosided\" true Shape \"trianglemesh\" "
         "\"point3 P\" "
         "[-1 -1 1  1 -1 1  1 1 1  -1 1 1] \"integer indices\" [0 1 2 0 2 3]",
         4 * 4 * std::sqrt(0.5) * std::atan(std::sqrt(0.5))},
        // The same square with its back to the plane.
        {"AreaLightSource \"diffuse\" \"rgb L\" [4 4 4] Shape \"bilinearmesh\" \"point3 P\" [-1 -1 1  1 -1 1 "
         " -1 1 1  1 1 1]",
         0},
        {"LightSource \"infinite\" \"rgb L\" [2 2 2]", 2 * kPi},
        {"LightSource \"infinite\" \"float illuminance\" 3", 3},
    };
    for (size_t i = 0; i < cases.size(); ++i)
        for (const std::string integrator : {"path", "volpath", "simplepath", "randomwalk"}) {
            const RenderSetup setup = PlaneUnder(cases[i].light, integrator);
            EXPECT_TRUE(
                Passes(FullTestName() + "/" + integrator + "/" + std::to_string(i), 1e-5, [&](uint64_t seed) {
                    const double expected = kAlbedo / kPi * cases[i].irradiance;
                    return ZTest(CenterRadiance(setup, 10000, seed), expected, 3e-5 * expected,
                                 cases[i].light);
                }));
        }
}

TEST(DirectLight, ChoiceAmongLightsIsWeightedRight) {
    // Many lights of different strengths: the sum of their closed forms, whatever the choice.
    std::string lights;
    double irradiance = 0;
    for (int i = 0; i < 7; ++i) {
        const double z = 1 + i, x = i - 3;
        lights += "LightSource \"point\" \"rgb I\" [1 1 1] \"float scale\" " + std::to_string(1 + i * i) +
                  " \"point3 from\" [" + std::to_string(x) + " 0 " + std::to_string(z) + "] ";
        irradiance += (1 + i * i) * z / std::pow(x * x + z * z, 1.5);
    }
    for (const std::string& sampler : Registry<LightSamplerKind>::Names()) {
        const RenderSetup setup = PlaneUnder(lights, "path", "\"string lightsampler\" \"" + sampler + "\"");
        EXPECT_TRUE(Passes(FullTestName() + "/" + sampler, 1e-5, [&](uint64_t seed) {
            return ZTest(CenterRadiance(setup, 5000, seed), kAlbedo / kPi * irradiance, 1e-5, sampler);
        }));
    }
}

TEST(DirectLight, InterfacesStopShadowRaysOfPathOnly) {
    const std::string behind =
        "LightSource \"point\" \"rgb I\" [7 7 7] \"point3 from\" [0 0 2] Material \"interface\" "
        "Translate 0 0 1 Shape \"disk\"";
    EXPECT_EQ(CenterRadiance(PlaneUnder(behind, "path"), 20).Mean(), 0);
    EXPECT_NEAR(CenterRadiance(PlaneUnder(behind, "volpath"), 20).Mean(), kAlbedo / kPi * 7 / 4, 1e-5);
}

TEST(DirectLight, OpaqueSurfacesCastShadows) {
    const std::string behind =
        "LightSource \"point\" \"rgb I\" [7 7 7] \"point3 from\" [0 0 2] Translate 0 0 1 Shape \"disk\"";
    for (const std::string integrator : {"path", "volpath", "simplepath"})
        EXPECT_EQ(CenterRadiance(PlaneUnder(behind, integrator), 20).Mean(), 0);
}

}  // namespace
}  // namespace lacquer::direct_light_test
