// Integrators that know nothing of each other's sampling find the same image.
#include <gtest/gtest.h>

#include "integrators/render_fixtures.h"

namespace lacquer::agreement_test {
namespace {

using test::FullTestName;
using test::Outcome;
using test::Passes;
using test::RunningMean;
using test::SeedOf;

constexpr double kAlpha = 1e-4;

std::string Numbers(std::initializer_list<float> values) {
    std::string text = "[";
    for (const float v : values) text += std::to_string(v) + " ";
    return text + "]";
}

/// Diffuse, glossy and translucent things at random places in a half-open room under large lights.
std::string RandomScene(uint64_t sceneSeed, const std::string& integrator, int samples, uint64_t seed,
                        float lightScale) {
    Rng rng(sceneSeed);
    const auto u = [&](float low, float high) { return Lerp(rng.Uniform(), low, high); };
    std::string text =
        "LookAt 0 1 -5  0 0 0  0 1 0 Camera \"perspective\" \"float fov\" 50 Film \"rgb\" \"integer "
        "xresolution\" 32 "
        "\"integer yresolution\" 32 Sampler \"independent\" \"integer pixelsamples\" " +
        std::to_string(samples) + " \"integer seed\" " + std::to_string(seed % 100000000) +
        " PixelFilter \"box\" Integrator \"" + integrator +
        "\" \"integer maxdepth\" 3 WorldBegin LightSource \"infinite\" \"float scale\" " +
        std::to_string(lightScale) + " \"rgb L\" " + Numbers({u(0.3f, 0.6f), u(0.3f, 0.6f), u(0.3f, 0.6f)});
    text += " AttributeBegin AreaLightSource \"diffuse\" \"bool twosided\" true \"float scale\" " +
            std::to_string(lightScale) + " \"rgb L\" " + Numbers({u(1, 2), u(1, 2), u(1, 2)}) +
            " Translate 0 3 0 Shape \"sphere\" \"float radius\" 1.5 AttributeEnd\n";
    for (int i = 0; i < 8; ++i) {
        const std::string color = Numbers({u(0.2f, 0.8f), u(0.2f, 0.8f), u(0.2f, 0.8f)});
        text += "AttributeBegin ";
        if (i % 3 == 0) text += "Material \"diffuse\" \"rgb reflectance\" " + color;
        if (i % 3 == 1) text += "Material \"conductor\" \"float roughness\" 0.5 \"rgb reflectance\" " + color;
        if (i % 3 == 2) text += "Material \"diffusetransmission\" \"rgb reflectance\" " + color;
        const Vec3 p(u(-2, 2), u(-1, 1), u(-1, 2));
        text += " Translate " + std::to_string(p.x) + " " + std::to_string(p.y) + " " + std::to_string(p.z);
        text += " Rotate " + std::to_string(u(0, 360)) + " 1 2 3 Shape " +
                (i % 2 ? "\"sphere\" \"float radius\" 0.6" : "\"disk\" \"float radius\" 1");
        text += " AttributeEnd\n";
    }
    return text + "Translate 0 -1.5 0 Rotate 90 1 0 0 Shape \"disk\" \"float radius\" 6";
}

/// Mean over pixels of the difference of two renderings, against 0.
Outcome Difference(const std::string& other, int otherSamples, float otherScale, uint64_t seed) {
    const uint64_t scene = SeedOf("Integrators.RandomScene");
    const auto a = test::RenderText(RandomScene(scene, "path", 64, Hash(seed, 1), 1));
    const auto b = test::RenderText(RandomScene(scene, other, otherSamples, Hash(seed, 2), otherScale));
    RunningMean difference;
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 32; ++x)
            difference.Add(test::LuminanceAt(*a, {x, y}) - test::LuminanceAt(*b, {x, y}));
    Outcome outcome = ZTest(difference, 0, 0, "path - " + other);
    outcome.details += ", of a mean luminance of " + std::to_string(test::PixelLuminance(*a).Mean());
    return outcome;
}

// Power: the standard errors of the differences are 0.0007 (simplepath), 0.0006 (randomwalk) and 0.0006
// (volpath) of a mean luminance of 0.242; a light off by 2 % is 6.9, 8 and 7 of them, and 3.9 are enough at
// 1e-4.
TEST(Integrators, PathAgreesWithSimplePath) {
    EXPECT_TRUE(
        Passes(FullTestName(), kAlpha, [](uint64_t seed) { return Difference("simplepath", 256, 1, seed); }));
}
TEST(Integrators, PathAgreesWithRandomWalk) {
    EXPECT_TRUE(
        Passes(FullTestName(), kAlpha, [](uint64_t seed) { return Difference("randomwalk", 512, 1, seed); }));
}
TEST(Integrators, PathAgreesWithVolPath) {
    EXPECT_TRUE(
        Passes(FullTestName(), kAlpha, [](uint64_t seed) { return Difference("volpath", 64, 1, seed); }));
}
TEST(Integrators, NegativeControlALightTwoPercentTooBrightIsFound) {
    EXPECT_LT(Difference("simplepath", 256, 1.02f, SeedOf(FullTestName())).pValue, kAlpha);
    EXPECT_LT(Difference("randomwalk", 512, 1.02f, SeedOf(FullTestName())).pValue, kAlpha);
}

}  // namespace
}  // namespace lacquer::agreement_test
