// Volumes whose radiance is known: transmittance, emission, single scattering, furnaces; and the integrators
// against each other.
#include <gtest/gtest.h>

#include "integrators/render_fixtures.h"

namespace lacquer::volume_test {
namespace {

using test::BuildText;
using test::CenterRadiance;
using test::FullTestName;
using test::Passes;
using test::RunningMean;
using test::SeedOf;
using test::ZTest;

constexpr double kAlpha = 1e-5;  // about forty runs in this file

/// A camera at (0, 0, -4) that looks along +z, through the middle of whatever stands at the origin.
std::string View(const std::string& integrator, int maxDepth, const std::string& medium = "") {
    return "LookAt 0 0 -4  0 0 0  0 1 0 " + medium +
           " Camera \"perspective\" Film \"rgb\" \"integer xresolution\" 4 \"integer yresolution\" 4 Sampler "
           "\"independent\" Integrator \"" +
           integrator + "\" \"integer maxdepth\" " + std::to_string(maxDepth) + " WorldBegin ";
}
std::string Medium(const std::string& parameters, const std::string& name = "m") {
    return "MakeNamedMedium \"" + name + "\" \"string type\" \"homogeneous\" " + parameters +
           " MediumInterface \"" + name + "\" \"\" ";
}
const std::string kWhite = "LightSource \"infinite\" \"rgb L\" [1 1 1] ";
const std::string kBall = "Material \"interface\" Shape \"sphere\" \"float radius\" 1 ";

std::string Grey(const std::string& name, double value) {
    const std::string v = std::to_string(value);
    return "\"rgb " + name + "\" [" + v + " " + v + " " + v + "] ";
}

RunningMean Measure(const std::string& scene, int samples, uint64_t seed) {
    return CenterRadiance(BuildText(scene), samples, seed);
}

/// True unless the mean differs from `expected` (at kAlpha, repeated with more samples as Passes() does).
bool Is(const std::string& what, const std::string& scene, double expected, int samples, double bias = 1e-5) {
    return Passes(FullTestName() + "/" + what, kAlpha,
                  [&](uint64_t seed) { return ZTest(Measure(scene, samples, seed), expected, bias, what); });
}

TEST(Volume, TransmittanceOfAbsorptionIsExact) {
    const std::string scene =
        View("volpath", 5) + kWhite + Medium(Grey("sigma_a", 0.7) + Grey("sigma_s", 0)) + kBall;
    const RunningMean mean = Measure(scene, 16, 1);
    EXPECT_NEAR(mean.Mean(), std::exp(-1.4), 2e-6);
    EXPECT_LT(mean.Variance(), 1e-12);  // no draw decides
}

// Power: the standard error is 0.5 %; a transmittance with a path off by 3 % is 10 of them.
TEST(Volume, UnscatteredLightIsWhatTheTransmittanceLeaves) {
    for (const std::string integrator : {"volpath", "simplevolpath"}) {
        const std::string scene =
            View(integrator, 0) + kWhite + Medium(Grey("sigma_a", 0.3) + Grey("sigma_s", 0.4)) + kBall;
        EXPECT_TRUE(Is(integrator, scene, std::exp(-1.4), 40000)) << integrator;
    }
}

TEST(Volume, NegativeControlAMediumThatIsThreePercentDenserIsFound) {
    const std::string scene =
        View("volpath", 0) + kWhite + Medium(Grey("sigma_a", 0.3) + Grey("sigma_s", 0.421)) + kBall;
    EXPECT_LT(ZTest(Measure(scene, 40000, SeedOf(FullTestName())), std::exp(-1.4), 1e-5, "").pValue, kAlpha);
}

TEST(Volume, EmissionIsWhatAbsorptionDoesNotTakeBack) {
    const std::string emission = Grey("Le", 1);
    const std::string absorbing = Medium(Grey("sigma_a", 0.7) + Grey("sigma_s", 0) + emission);
    EXPECT_NEAR(Measure(View("volpath", 5) + absorbing + kBall, 16, 1).Mean(), 1 - std::exp(-1.4), 2e-6);
    // With scattering, before any: Le sigma_a / sigma_t (1 - exp(-sigma_t d)).
    const double expected = 0.3 / 0.7 * (1 - std::exp(-1.4));
    for (const std::string integrator : {"volpath", "simplevolpath"})
        EXPECT_TRUE(
            Is(integrator,
               View(integrator, 0) + Medium(Grey("sigma_a", 0.3) + Grey("sigma_s", 0.4) + emission) + kBall,
               expected, 40000));
}

TEST(Volume, Lossless) {
    // White surroundings, nothing absorbed: 1 wherever one looks. Scattering that depends on the wavelength
    // would show any mistake of the spectral weights; the ball of glass those of crossings, and the far wall
    // of light those of the weights between light samples and scattering.
    const std::string chromatic = "\"rgb sigma_a\" [0 0 0] \"rgb sigma_s\" [0.5 2 6] \"float g\" 0.6 ";
    const std::string wall =
        "AttributeBegin Material \"diffuse\" \"rgb reflectance\" [0 0 0] AreaLightSource \"diffuse\" \"rgb "
        "L\" [1 1 1] "
        "ReverseOrientation Shape \"sphere\" \"float radius\" 9 AttributeEnd ";
    const std::string view = View("volpath", 4000);
    const std::string glass = "Material \"dielectric\" Shape \"sphere\" \"float radius\" 1 ";
    // Power: the standard errors are below 0.1 %: the 0.2 % asked for are two of them, 1 % would be ten.
    EXPECT_TRUE(Is("interface", view + kWhite + Medium(chromatic) + kBall, 1, 20000, 1e-4));
    EXPECT_TRUE(Is("glass", view + kWhite + Medium(chromatic) + glass, 1, 8000, 1e-4));
    EXPECT_TRUE(Is("wall", view + wall + Medium(chromatic) + kBall, 1, 40000, 1e-4));
    EXPECT_TRUE(Is("rough",
                   view + wall + Medium(chromatic) +
                       "Material \"dielectric\" \"float roughness\" 0.0001 "
                       "Shape \"sphere\" \"float radius\" 1 ",
                   1, 20000, 1e-4));
    EXPECT_TRUE(
        Is("simple", View("simplevolpath", 4000) + kWhite + Medium(chromatic) + kBall, 1, 2000, 1e-4));
}

TEST(Volume, NegativeControlALossOfOneInTwoHundredIsFound) {
    const std::string lossy = "\"rgb sigma_a\" [0.01 0.01 0.01] \"rgb sigma_s\" [2 2 2] \"float g\" 0.6 ";
    EXPECT_LT(
        ZTest(Measure(View("volpath", 4000) + kWhite + Medium(lossy) + kBall, 20000, SeedOf(FullTestName())),
              1, 1e-4, "")
            .pValue,
        kAlpha);
}

/// Radiance of light scattered once in an endless medium, from an isotropic point light of intensity 1 at
/// distance `off` beside the point that is `along` in front of the camera: the integral over the ray by the
/// midpoint rule.
double SingleScattering(double sigma_a, double sigma_s, double g, double along, double off) {
    const double sigma_t = sigma_a + sigma_s;
    constexpr int kSteps = 200000;
    const double far = 40;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
        const double s = (i + 0.5) * far / kSteps;
        const double d2 = (along - s) * (along - s) + off * off;
        // The light travels from its place to the point, then back to the camera: cosine between the two
        // ways.
        const double cosine = -(s - along) / std::sqrt(d2) * 1;
        const double phase = (1 - g * g) / (4 * double(Pi) * std::pow(1 + g * g - 2 * g * cosine, 1.5));
        sum += std::exp(-sigma_t * (s + std::sqrt(d2))) * sigma_s * phase / d2;
    }
    return sum * far / kSteps;
}

TEST(Volume, SingleScatteringIsItsIntegral) {
    const std::string medium = "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" \"float g\" 0.5 " +
                               Grey("sigma_a", 0.1) + Grey("sigma_s", 0.3) + " MediumInterface \"\" \"m\" ";
    const std::string light = "LightSource \"point\" \"rgb I\" [1 1 1] \"point3 from\" [0 2 1] ";
    const double expected = SingleScattering(0.1, 0.3, 0.5, 5, 2);
    // Power: the standard error is below 0.5 %; the phase function the wrong way round would be off by half.
    EXPECT_TRUE(Is("point", View("volpath", 1, medium) + light, expected, 60000));
    EXPECT_GT(std::abs(SingleScattering(0.1, 0.3, -0.5, 5, 2) / expected - 1), 0.2);
    EXPECT_GT(std::abs(SingleScattering(0.1, 0.33, 0.5, 5, 2) / expected - 1), 0.03);
}

TEST(Volume, IntegratorsAgree) {
    // A bright patch of sky, a coloured medium, all orders of scattering: volpath samples lights,
    // simplevolpath does not.
    const std::string rest =
        "LightSource \"infinite\" \"rgb L\" [0.6 0.4 0.3] AttributeBegin Translate 0 2 0 " +
        Medium(
            "\"rgb sigma_a\" [0.2 0.1 0.4] \"rgb sigma_s\" [1 2 3] \"float g\" -0.3 \"rgb Le\" [0.1 0.2 "
            "0.1]",
            "other") +
        kBall + "AttributeEnd " +
        Medium("\"rgb sigma_a\" [0.3 0.1 0.1] \"rgb sigma_s\" [3 1 2] \"float g\" 0.4 ") + kBall;
    EXPECT_TRUE(Passes(FullTestName(), kAlpha, [&](uint64_t seed) {
        const RunningMean a = Measure(View("volpath", 100) + rest, 20000, seed);
        const RunningMean b = Measure(View("simplevolpath", 100) + rest, 80000, seed + 1);
        const double error = std::hypot(a.StandardError(), b.StandardError());
        return test::Outcome{
            test::NormalTwoSided((a.Mean() - b.Mean()) / error),
            "volpath " + std::to_string(a.Mean()) + ", simplevolpath " + std::to_string(b.Mean())};
    }));
}

TEST(Volume, WithoutAMediumVolpathIsPathBitByBit) {
    const std::string rest =
        "LightSource \"infinite\" \"rgb L\" [0.6 0.4 0.3] Material \"coateddiffuse\" Shape \"sphere\" "
        "AttributeBegin "
        "Translate 0 0 3 AreaLightSource \"diffuse\" Shape \"disk\" AttributeEnd ";
    // A medium that no surface and no camera has makes the integrator expect media.
    const std::string unused = "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" ";
    const auto pixels = [](const std::string& text) { return test::RenderText(text)->Pixels(); };
    const std::vector<float> path = pixels(View("path", 5) + rest);
    EXPECT_EQ(path, pixels(View("volpath", 5) + rest));
    EXPECT_EQ(path, pixels(View("volpath", 5) + unused + rest));
    EXPECT_NE(path, pixels(View("volpath", 0) + rest));
}

TEST(Volume, DispersionAfterColouredScatteringKeepsEveryColour) {
    // A ball of glass whose index hardly varies, in a medium of strong colours: the paths lose three
    // wavelengths at the glass, but what was found before belongs to all. Counting it for one alone
    // makes red 24 % too bright.
    const auto red = [](const std::string& eta, int seed) {
        RunningMean mean;
        for (int run = 0; run < 24; ++run) {
            const auto image = test::RenderText(
                "LookAt 0 0 -4  0 0 0  0 1 0 Camera \"perspective\" \"float fov\" 20 Film \"rgb\" \"integer "
                "xresolution\" 4 \"integer yresolution\" 4 Sampler \"independent\" \"integer pixelsamples\" "
                "64 "
                "\"integer seed\" " +
                std::to_string(seed + run) + " Integrator \"volpath\" \"integer maxdepth\" 30 WorldBegin " +
                Medium("\"rgb sigma_a\" [0.05 0.05 0.05] \"rgb sigma_s\" [2 0.2 0.05] \"rgb Le\" [1 1 1] ") +
                "Material \"interface\" Shape \"sphere\" \"float radius\" 1.5 MediumInterface \"\" \"m\" "
                "Material \"dielectric\" " +
                eta + " Shape \"sphere\" \"float radius\" 0.8 ");
            double sum = 0;
            for (int i = 0; i < 16; ++i) sum += double(image->Get({i % 4, i / 4}, 0));
            mean.Add(sum / 16);
        }
        return mean;
    };
    EXPECT_TRUE(Passes(FullTestName(), kAlpha, [&](uint64_t seed) {
        const int first = int(seed % 1000000);
        const RunningMean constant = red("\"float eta\" 1.5", first);
        const RunningMean varying = red("\"spectrum eta\" [300 1.5 900 1.50001]", first + 1000000);
        const double error = std::hypot(constant.StandardError(), varying.StandardError());
        // Power: the error is below 3 % of the value.
        EXPECT_LT(error, 0.03 * constant.Mean());
        return test::Outcome{test::NormalTwoSided((constant.Mean() - varying.Mean()) / error),
                             std::to_string(constant.Mean()) + " and " + std::to_string(varying.Mean())};
    }));
}

TEST(Volume, HugeMajorantsThatBoundNothingEnd) {
    // Density 0 on the left: flights there are far shorter than positions can tell.
    const std::string grid =
        "MakeNamedMedium \"m\" \"string type\" \"uniformgrid\" \"integer nx\" 2 \"float density\" [0 1] "
        "\"point3 p0\" "
        "[-1 -1 -1] \"point3 p1\" [1 1 1] \"rgb sigma_a\" [0 0 0] \"rgb sigma_s\" [1 1 1] \"float scale\" "
        "1e12 "
        "MediumInterface \"m\" \"\" ";
    EXPECT_GT(Measure(View("volpath", 1000) + kWhite + grid + kBall, 16, 1).Mean(), 0);
}

TEST(Volume, ShadowsOfInfiniteLightAreBlack) {
    // So near the light that its radiance is no float; a disk is in between.
    const std::string lamp =
        "LookAt 0.05 0 0.01  0 0 0  0 0 1 MakeNamedMedium \"m\" \"string type\" \"homogeneous\" " +
        Grey("sigma_a", 0.1) + Grey("sigma_s", 0.5) +
        "MediumInterface \"\" \"m\" Camera \"perspective\" \"float fov\" 20 Film \"rgb\" \"integer "
        "xresolution\" 8 \"integer yresolution\" 8 Sampler \"independent\" Integrator \"volpath\" "
        "\"integer maxdepth\" 1 WorldBegin MediumInterface \"m\" \"m\" LightSource \"point\" \"rgb I\" [3 3 "
        "3] "
        "\"float scale\" 1e38 \"point3 from\" [0 0 0.03] Material \"diffuse\" Shape \"bilinearmesh\" "
        "\"point3 P\" [-5 -5 0  5 -5 0  -5 5 0  5 5 0] ";
    const auto bad = [](const std::string& text) {
        const RenderSetup setup = test::BuildText(text);
        const RenderStats stats = test::RenderAll(setup);
        EXPECT_FALSE(setup.film->Develop()->HasNonFinite());
        return stats.badSamples;
    };
    EXPECT_GT(bad(lamp), 0);
    EXPECT_EQ(bad(lamp + "Translate 0 0 0.02 Shape \"disk\""), 0);
}

TEST(Volume, PathTakesMediaForVacuum) {
    const std::string medium = Medium(Grey("sigma_a", 3));  // with a warning: tests/scene/builder_test.cpp
    EXPECT_NEAR(Measure(View("path", 5) + kWhite + medium + kBall, 16, 1).Mean(), 1, 1e-5);
}

}  // namespace
}  // namespace lacquer::volume_test
