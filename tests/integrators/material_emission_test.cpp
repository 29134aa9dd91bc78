// Light that materials emit, against AreaLightSource directives that say the same.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "integrators/render_fixtures.h"

namespace lacquer::material_emission_test {
namespace {

using test::BuildText;

/// A glowing sphere of an OpenPBR material beside a grey floor.
std::string Scene(const std::string& emission, const std::string& areaLight,
                  const std::string& integrator = "path") {
    return fmt::format(R"(Film "rgb" "integer xresolution" 24 "integer yresolution" 16
Sampler "independent" "integer pixelsamples" 4 Integrator "{}" Camera "perspective"
WorldBegin AttributeBegin Translate 0 0 4 {} Material "openpbr" "rgb base_color" [0.6 0.3 0.2] {}
Shape "sphere" "float radius" 0.8 AttributeEnd
Material "diffuse" Translate 0 -1.5 4 Scale 8 1 8 Rotate 90 1 0 0 Shape "disk")",
                       integrator, areaLight, emission);
}
constexpr const char* kEmission = "\"float emission_luminance\" 2.5 \"rgb emission_color\" [1 0.5 0.2] ";
constexpr const char* kLight = "AreaLightSource \"diffuse\" \"float scale\" 2.5 \"rgb L\" [1 0.5 0.2] ";

double LargestDifference(const Image& a, const Image& b) {
    double largest = 0;
    for (size_t i = 0; i < a.Pixels().size(); ++i)
        largest = std::max(largest, std::abs(double(a.Pixels()[i]) - double(b.Pixels()[i])));
    return largest;
}

TEST(MaterialEmission, RendersAsAnAreaLight) {
    for (const char* integrator : {"path", "bdpt"}) {
        const auto byMaterial = test::RenderText(Scene(kEmission, "", integrator));
        EXPECT_EQ(LargestDifference(*byMaterial, *test::RenderText(Scene("", kLight, integrator))), 0)
            << integrator;
        EXPECT_GT(test::PixelLuminance(*byMaterial).Mean(), 0.01);
    }
    // It would notice a hundredth of the light.
    EXPECT_GT(
        LargestDifference(*test::RenderText(Scene(
                              "\"float emission_luminance\" 2.525 \"rgb emission_color\" [1 0.5 0.2]", "")),
                          *test::RenderText(Scene("", kLight))),
        1e-3);
}

double PowerOf(const std::string& emission, const std::string& areaLight = "", Observer* observer = nullptr) {
    const RenderSetup setup = BuildText(Scene(emission, areaLight), observer);
    double power = 0;
    for (const Light* light : setup.scene->Lights()) power += double(light->Power());
    return power;
}
const double kUnit = 4 * double(Pi) * 0.64 * double(Pi);  ///< power of the sphere for a radiance of 1

TEST(MaterialEmission, IsWhatTheParametersSay) {
    EXPECT_NEAR(PowerOf("\"float emission_luminance\" 3"), 3 * kUnit, 1e-4 * kUnit);
    // A spectrum has the luminance, too, and a hole emits nothing.
    EXPECT_NEAR(PowerOf("\"float emission_luminance\" 3 \"blackbody emission_color\" 4000"), 3 * kUnit,
                1e-3 * kUnit);
    EXPECT_NEAR(PowerOf("\"float emission_luminance\" 3 \"float geometry_opacity\" 0.25"), 0.75 * kUnit,
                1e-4 * kUnit);
    EXPECT_NEAR(PowerOf("\"float emission_luminance\" 3 \"bool geometry_thin_walled\" true"), 6 * kUnit,
                1e-4 * kUnit);
    for (const char* none : {"", "\"float emission_luminance\" 0", "\"rgb emission_color\" [1 1 1]",
                             "\"float emission_luminance\" 3 \"float geometry_opacity\" 0"})
        EXPECT_EQ(PowerOf(none), 0) << none;
}

TEST(MaterialEmission, GivesWayToAnAreaLightSource) {
    test::WarningList warnings;
    EXPECT_NEAR(
        PowerOf("\"float emission_luminance\" 3", "AreaLightSource \"diffuse\" \"float scale\" 7", &warnings),
        7 * kUnit, 1e-3 * kUnit);
    EXPECT_NE(warnings.text.find("takes the place of its material's emission"), std::string::npos)
        << warnings.text;
}

}  // namespace
}  // namespace lacquer::material_emission_test
