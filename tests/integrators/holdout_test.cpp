// Holdouts: holes for the camera, and surfaces for everything else.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "pbrt/film/aov.h"
#include "render_fixtures.h"

namespace lacquer {
namespace {

constexpr int kSize = 16;

/// An emitting, grey card in front of the left half of the image, held out or not; behind it and to its right
/// a mirror floor, a wall and the sky; a lamp whose shadows the card casts.
std::string Scene(const std::string& integrator, const std::string& holdout, int samples = 8) {
    return fmt::format(R"(
        Camera "perspective" "float fov" 90 Film "rgb" "integer xresolution" {0} "integer yresolution" {0}
        Sampler "independent" "integer pixelsamples" {3} PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
        Integrator {1}
        WorldBegin
        LightSource "infinite" "rgb L" [.2 .3 .4]
        AttributeBegin
            AreaLightSource "diffuse" "rgb L" [9 9 9] "bool twosided" true
            Shape "bilinearmesh" "point3 P" [1 .5 -1  2 .5 -1  1 1.5 -1  2 1.5 -1]
        AttributeEnd
        AttributeBegin
            AreaLightSource "diffuse" "rgb L" [2 1 1] "bool twosided" true
            Material "diffuse" "rgb reflectance" [.5 .5 .5] {2}
            Shape "bilinearmesh" "point3 P" [-2 -2 2  0 -2 2  -2 2 2  0 2 2]
        AttributeEnd
        Material "diffuse" "rgb reflectance" [.7 .7 .2]
        Shape "bilinearmesh" "point3 P" [-5 -5 4  5 -5 4  -5 5 4  5 5 4]
        Material "conductor" "float roughness" 0.1
        Shape "bilinearmesh" "point3 P" [-5 -1 2.1  5 -1 2.1  -5 -1 4  5 -1 4]
    )",
                       kSize, integrator, holdout, samples);
}

std::unique_ptr<Image> Rendered(const std::string& integrator, const std::string& holdout, int samples = 8) {
    const RenderSetup setup = test::BuildText(Scene(integrator, holdout, samples));
    AovSetup aovSetup;
    aovSetup.pixelBounds = setup.film->PixelBounds();
    aovSetup.spaces = {&setup.film->ColorSpace(), setup.renderFromWorld,
                       setup.scene->Camera().RenderFromCamera()};
    AovBuffer aovs({"alpha", "depth"}, aovSetup);
    RenderOptions options;
    options.aovs = &aovs;
    test::RenderAll(setup, options);
    return aovs.AppendTo(*setup.film->Develop());
}

/// Sums of the absolute values of R, G and B in the columns [begin, end), and of alpha.
struct Part {
    double light = 0, alpha = 0;
};
Part SumOf(const Image& image, int begin, int end) {
    Part sum;
    const int alpha = image.FindChannel("A");
    for (int y = 0; y < kSize; ++y)
        for (int x = begin; x < end; ++x) {
            for (int c = 0; c < 3; ++c) sum.light += std::abs(double(image.Get({x, y}, c)));
            sum.alpha += double(image.Get({x, y}, alpha));
        }
    return sum;
}

class Holdout : public testing::TestWithParam<const char*> {};

/// Of every integrator: nothing of the card is left, and where the camera sees something else the bits are
/// those of a card that is seen, its light and its shadows included.
TEST_P(Holdout, IsAHoleForTheCameraAlone) {
    const auto seen = Rendered(GetParam(), ""), held = Rendered(GetParam(), "\"bool holdout\" true");
    const int half = kSize / 2, all = half * kSize;
    EXPECT_GT(SumOf(*seen, 0, half).light, 0);
    EXPECT_EQ(SumOf(*seen, 0, half).alpha, all);
    EXPECT_EQ(SumOf(*held, 0, half).light, 0);
    EXPECT_EQ(SumOf(*held, 0, half).alpha, 0);
    for (int y = 0; y < kSize; ++y)
        for (int x = half; x < kSize; ++x)
            for (int c = 0; c < seen->NumChannels(); ++c)
                ASSERT_EQ(seen->Get({x, y}, c), held->Get({x, y}, c)) << x << ' ' << y << ' ' << c;
    EXPECT_GT(SumOf(*held, half, kSize).light, 0);
    EXPECT_EQ(SumOf(*held, half, kSize).alpha, all);
}

INSTANTIATE_TEST_SUITE_P(All, Holdout,
                         testing::Values(R"("path" "integer maxdepth" 4)",
                                         R"("volpath" "integer maxdepth" 4)",
                                         R"("simplepath" "integer maxdepth" 4)",
                                         R"("lightpath" "integer maxdepth" 4)",
                                         R"("randomwalk" "integer maxdepth" 4)", R"("ambientocclusion")"));

/// Where a path from the camera ends early, this integrator draws the next one from the light by other
/// numbers, so what it adds elsewhere is equal in the mean alone: within 4 standard errors over the pixels,
/// which is 1 % here.
TEST(HoldoutBidirectional, IsAHoleForTheCameraAlone) {
    const std::string bdpt = R"("bdpt" "integer maxdepth" 4)";
    const auto seen = Rendered(bdpt, "", 100), held = Rendered(bdpt, "\"bool holdout\" true", 100);
    EXPECT_GT(SumOf(*seen, 0, kSize / 2).light, 0);
    EXPECT_EQ(SumOf(*held, 0, kSize / 2).light, 0);
    EXPECT_EQ(SumOf(*held, 0, kSize / 2).alpha, 0);
    test::RunningMean difference, luminance;
    for (int y = 0; y < kSize; ++y)
        for (int x = kSize / 2; x < kSize; ++x) {
            luminance.Add(test::LuminanceAt(*seen, {x, y}));
            difference.Add(test::LuminanceAt(*held, {x, y}) - test::LuminanceAt(*seen, {x, y}));
        }
    EXPECT_LE(std::abs(difference.Mean()), 4 * difference.StandardError());
    EXPECT_LT(4 * difference.StandardError(), 0.01 * luminance.Mean());
}

/// Without the card the lamp and the wall look different on the right: the test above would see a card that
/// is gone.
TEST(HoldoutControl, TheCardIsSeenElsewhere) {
    const auto seen = Rendered("\"path\"", "");
    std::string text = Scene("\"path\"", "");
    text.erase(text.rfind("AttributeBegin"), text.rfind("AttributeEnd") + 12 - text.rfind("AttributeBegin"));
    const auto without = test::RenderText(text);
    EXPECT_GT(std::abs(SumOf(*seen, kSize / 2, kSize).light -
                       [&] {
                           double sum = 0;
                           for (int y = 0; y < kSize; ++y)
                               for (int x = kSize / 2; x < kSize; ++x)
                                   for (int c = 0; c < 3; ++c) sum += double(without->Get({x, y}, c));
                           return sum;
                       }()),
              1);
}

/// By way of a mixture, which is what the shape has; an interface stays one; a mirror shows what is held out.
TEST(HoldoutMaterials, AreThoseOfTheShape) {
    const auto lightOf = [](const std::string& materials) {
        const auto image = test::RenderText(fmt::format(
            R"(Camera "orthographic" Film "rgb" "integer xresolution" 4 "integer yresolution" 4
               Sampler "independent" "integer pixelsamples" 4 Integrator "path"
               WorldBegin LightSource "infinite" Translate 0 0 4 {})",
            materials));
        return test::PixelLuminance(*image).Mean();
    };
    const std::string parts = R"(MakeNamedMaterial "a" "string type" "diffuse"
                                 MakeNamedMaterial "b" "string type" "diffuse" "bool holdout" true )";
    const std::string disk = R"( Shape "disk" "float radius" 3)";
    EXPECT_EQ(lightOf(parts + R"(Material "mix" "string materials" ["a" "a"] "bool holdout" true)" + disk),
              0);
    EXPECT_GT(lightOf(parts + R"(Material "mix" "string materials" ["b" "b"])" + disk), 0.1);
    EXPECT_EQ(lightOf(R"(Material "interface" "bool holdout" true)" + disk), lightOf(""));
    // Seen in a mirror that looks back at the held-out disk behind the camera.
    const std::string behind =
        R"( Translate 0 0 -8 Material "diffuse" "rgb reflectance" [.5 .5 .5] {} )" + disk;
    const std::string mirror = R"(Material "conductor" "float roughness" 0)" + disk;
    EXPECT_EQ(lightOf(mirror + fmt::format(fmt::runtime(behind), "\"bool holdout\" true")),
              lightOf(mirror + fmt::format(fmt::runtime(behind), "")));
}

}  // namespace
}  // namespace lacquer
