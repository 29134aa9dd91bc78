// Scenes in which the radiance is known everywhere.
#include <gtest/gtest.h>

#include "integrators/render_fixtures.h"

namespace lacquer::furnace_test {
namespace {

using test::BuildText;
using test::CenterRadiance;
using test::FullTestName;
using test::Outcome;
using test::Passes;
using test::SeedOf;

constexpr double kAlpha = 1e-5;  // about forty runs in this file

std::string Number(double x) { return std::to_string(x); }

/// A closed room with an emission of 1/2 on all its walls, seen from an odd place inside.
std::string Room(const std::string& integrator, const std::string& shape, double albedo,
                 const std::string& extra = "") {
    const std::string grey = Number(albedo);
    return "LookAt 0.3 -0.2 0.1  0.9 0.7 0.4  0 1 0 Camera \"perspective\" Film \"rgb\" \"integer "
           "xresolution\" 4 "
           "\"integer yresolution\" 4 Sampler \"independent\" Integrator \"" +
           integrator + "\" \"integer maxdepth\" 60 " + extra +
           " WorldBegin Material \"diffuse\" \"rgb reflectance\" [" + grey + " " + grey + " " + grey +
           "] AreaLightSource \"diffuse\" \"rgb L\" [0.5 0.5 0.5] " + shape;
}
const std::string kSphere = "ReverseOrientation Shape \"sphere\" \"float radius\" 2";
// Triangles that face inwards.
const std::string kBox =
    "Shape \"trianglemesh\" \"point3 P\" [-2 -2 -2  2 -2 -2  2 2 -2  -2 2 -2  -2 -2 2  2 -2 2  2 2 2  -2 2 "
    "2] "
    "\"integer indices\" [0 1 2 0 2 3  4 6 5 4 7 6  0 5 1 0 4 5  3 2 6 3 6 7  0 3 7 0 7 4  1 5 6 1 6 2]";

TEST(Furnace, TheBoxFacesInwards) {
    const auto setup = BuildText(Room("path", kBox, 0.5));
    for (const Vec3 d :
         {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 1, 0), Vec3(0, -1, 0), Vec3(0, 0, 1), Vec3(0, 0, -1)}) {
        SurfaceInteraction si;
        ASSERT_TRUE(test::NearestHit(setup, {{0, 0, 0}, d, 0}, &si));
        EXPECT_LT(Dot(si.n, d), 0);
        EXPECT_NE(si.areaLight, nullptr);
    }
}

// Power: the standard errors are 0.5 % (path, albedo 0.5), 0.8 % (path, 0.8), below 1 % (simplepath) and 0.6
// % (randomwalk); a missing bounce (a^k) or a light strength off by 5 % is 5 of them or more.
TEST(Furnace, RadianceIsEmissionOverOneMinusAlbedo) {
    for (const auto& [name, shape] : {std::pair<std::string, std::string>("sphere", kSphere), {"box", kBox}})
        for (const std::string integrator : {"path", "volpath", "simplepath", "randomwalk"})
            for (const double albedo : {0.5, 0.8}) {
                // A bounce of uniform directions multiplies the second moment by 8 a^2 / 3: from a = 0.61 it
                // is infinite.
                if (integrator == "randomwalk" && albedo > 0.6) continue;
                const RenderSetup setup = BuildText(Room(integrator, shape, albedo));
                const int samples = integrator == "randomwalk"   ? 30000
                                    : integrator == "simplepath" ? 3000
                                                                 : 10000;
                EXPECT_TRUE(Passes(FullTestName() + "/" + name + "/" + integrator + "/" + Number(albedo),
                                   kAlpha, [&](uint64_t seed) {
                                       // 60 bounces leave out 2.5 * 0.8^61 = 3e-6; the rest is the rounding
                                       // of 30 factors.
                                       return ZTest(CenterRadiance(setup, samples, seed), 0.5 / (1 - albedo),
                                                    1e-4, integrator);
                                   }));
            }
}

TEST(Furnace, NegativeControlAnAlbedoOffByFivePercentIsFound) {
    const RenderSetup setup = BuildText(Room("path", kBox, 0.525));
    EXPECT_LT(ZTest(CenterRadiance(setup, 10000, SeedOf(FullTestName())), 1, 1e-4, "path").pValue, kAlpha);
}

TEST(Furnace, DepthCountsScatteringVertices) {
    // E (1 + a + ... + a^depth).
    double sum = 0;
    for (int depth = 0; depth <= 3; ++depth) {
        sum += 0.5 * std::pow(0.5, depth);
        for (const std::string integrator : {"path", "simplepath", "randomwalk"}) {
            const RenderSetup setup =
                BuildText(Room(integrator, kBox, 0.5, "\"integer maxdepth\" " + std::to_string(depth)));
            EXPECT_TRUE(Passes(
                FullTestName() + "/" + integrator + "/" + std::to_string(depth), kAlpha, [&](uint64_t seed) {
                    return ZTest(CenterRadiance(setup, integrator == "randomwalk" ? 20000 : 5000, seed), sum,
                                 1e-4, integrator);
                }));
        }
    }
}

/// A white sphere in a white environment: radiance 1 wherever one looks.
std::string WhiteWorld(const std::string& sampler, const std::string& filter, const std::string& integrator,
                       int size) {
    return "LookAt 0 0 -4  0 0 0  0 1 0 Camera \"perspective\" \"float fov\" 50 Film \"rgb\" \"integer "
           "xresolution\" " +
           std::to_string(size) + " \"integer yresolution\" " + std::to_string(size) + " Sampler " + sampler +
           " PixelFilter \"" + filter + "\" Integrator \"" + integrator +
           "\" WorldBegin LightSource \"infinite\" \"rgb L\" [1 1 1] Material \"diffuse\" \"rgb "
           "reflectance\" [1 1 1] Shape \"sphere\"";
}

/// Standard deviation of the luminance of one sample of a white of 1: wavelengths alone.
double ColorNoise() {
    test::RunningMean y;
    for (int i = 0; i < 1000; ++i) {
        const SampledWavelengths lambda = SampledWavelengths::SampleVisible((float(i) + 0.5f) / 1000);
        const SampledSpectrum L = ColorSpace::SRGB().Illuminant().Sample(lambda) / kCieYIntegral;
        y.Add(double(SafeDivide(L * CieY().Sample(lambda), lambda.Pdf()).Average()));
    }
    return std::sqrt(y.Variance());
}

TEST(WhiteWorld, IsOneThroughEverySampler) {
    constexpr int kSize = 16, kSamples = 16;
    // Each sample of the path integrator is exactly white here; stratified wavelengths do no worse than
    // independent ones.
    const double tolerance = 5 * ColorNoise() / std::sqrt(double(kSize) * kSize * kSamples);
    EXPECT_LT(tolerance, 0.03);
    for (const std::string& name : Registry<SamplerKind>::Names()) {
        const std::string count = name == "stratified" ? "" : " \"integer pixelsamples\" 16";
        const auto image = test::RenderText(WhiteWorld("\"" + name + "\"" + count, "box", "path", kSize));
        EXPECT_NEAR(test::PixelLuminance(*image).Mean(), 1, tolerance) << name;
    }
}

TEST(WhiteWorld, IsOneThroughEveryFilter) {
    constexpr int kSize = 16, kSamples = 64;
    for (const std::string& name : Registry<FilterKind>::Names()) {
        const auto image =
            test::RenderText(WhiteWorld("\"independent\" \"integer pixelsamples\" 64", name, "path", kSize));
        // Negative lobes raise the noise of a pixel by the mean of |w| over that of w, less than 2 here.
        EXPECT_NEAR(test::PixelLuminance(*image).Mean(), 1,
                    2 * 5 * ColorNoise() / std::sqrt(double(kSize) * kSize * kSamples))
            << name;
    }
}

TEST(WhiteWorld, IsOneThroughEveryIntegrator) {
    for (const std::string& name : Registry<IntegratorKind>::Names()) {
        // Shows how open surfaces are; shows no background; knows no surfaces.
        if (name == "ambientocclusion" || name == "lightpath" || name == "simplevolpath") continue;
        EXPECT_TRUE(Passes(FullTestName() + "/" + name, kAlpha, [&](uint64_t seed) {
            const std::string sampler = "\"independent\" \"integer pixelsamples\" 16 \"integer seed\" " +
                                        std::to_string(seed % 1000000);
            const auto image = test::RenderText(WhiteWorld(sampler, "gaussian", name, 32));
            return ZTest(test::PixelLuminance(*image), 1, 1e-4, name);
        }));
    }
}

TEST(WhiteWorld, EachSampleOfThePathIntegratorIsWhite) {
    // Uniform environments are found by scattered rays alone, with weight 1: no noise but that of
    // wavelengths.
    for (const std::string material :
         {"Material \"diffuse\" \"rgb reflectance\" [1 1 1]", "Material \"thindielectric\"",
          "Material \"interface\"", "Material \"dielectric\" \"float eta\" 1.5"}) {
        const RenderSetup setup = BuildText(
            "LookAt 0 0 -4  0 0 0  0 1 0 Camera \"perspective\" Film \"rgb\" \"integer xresolution\" 4 "
            "\"integer yresolution\" 4 "
            "Sampler \"independent\" Integrator \"path\" \"integer maxdepth\" 100000 WorldBegin "
            "LightSource \"infinite\" \"rgb L\" [1 1 1] " +
            material + " Shape \"sphere\"");
        const test::RunningMean mean = CenterRadiance(setup, 2000);
        EXPECT_NEAR(mean.Mean(), 1, 1e-5) << material;
        EXPECT_LT(mean.Variance(), 1e-9) << material;
    }
}

}  // namespace
}  // namespace lacquer::furnace_test
