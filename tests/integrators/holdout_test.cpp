// Holdouts: holes for the camera, and surfaces for everything else.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "pbrt/film/aov.h"
#include "pbrt/integrators/rendered_image.h"
#include "render_fixtures.h"

namespace lacquer::holdout_test {
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

std::unique_ptr<Image> RenderedText(const std::string& text, bool isJittered = true) {
    const RenderSetup setup = test::BuildText(text);
    AovSetup aovSetup;
    aovSetup.pixelBounds = setup.film->PixelBounds();
    aovSetup.spaces = {&setup.film->ColorSpace(), setup.renderFromWorld,
                       setup.scene->Camera().RenderFromCamera()};
    AovBuffer aovs({"alpha", "depth"}, aovSetup);
    RenderOptions options;
    options.aovs = &aovs;
    options.jitter.pixels = isJittered;
    test::RenderAll(setup, options);
    return aovs.AppendTo(*setup.film->Develop());
}
std::unique_ptr<Image> Rendered(const std::string& integrator, const std::string& holdout, int samples = 8) {
    return RenderedText(Scene(integrator, holdout, samples));
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

/// That the columns of the right half have the same mean luminance, to 4 standard errors over the pixels.
/// @param precision  part of the luminance that these have to be below
void ExpectSameMeanOnTheRight(const Image& seen, const Image& held, double precision) {
    test::RunningMean difference, luminance;
    for (int y = 0; y < kSize; ++y)
        for (int x = kSize / 2; x < kSize; ++x) {
            luminance.Add(test::LuminanceAt(seen, {x, y}));
            difference.Add(test::LuminanceAt(held, {x, y}) - test::LuminanceAt(seen, {x, y}));
        }
    EXPECT_LE(std::abs(difference.Mean()), 4 * difference.StandardError());
    EXPECT_LT(4 * difference.StandardError(), precision * luminance.Mean());
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
/// numbers, so what it adds elsewhere is equal in the mean alone.
TEST(HoldoutBidirectional, IsAHoleForTheCameraAlone) {
    const std::string bdpt = R"("bdpt" "integer maxdepth" 4)";
    const auto seen = Rendered(bdpt, "", 100), held = Rendered(bdpt, "\"bool holdout\" true", 100);
    EXPECT_GT(SumOf(*seen, 0, kSize / 2).light, 0);
    EXPECT_EQ(SumOf(*held, 0, kSize / 2).light, 0);
    EXPECT_EQ(SumOf(*held, 0, kSize / 2).alpha, 0);
    ExpectSameMeanOnTheRight(*seen, *held, 0.01);
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

// ---- With everything else ---------------------------------------------------------------------------------

constexpr const char* kCard = R"(Material "diffuse" "rgb reflectance" [.5 .5 .5])";
constexpr const char* kHoldout = R"("bool holdout" true)";
/// The scene above with another card, and with directives before it and before the world.
std::string SceneOf(const std::string& integrator, const std::string& card, int samples,
                    const std::string& parts = "", const std::string& head = "") {
    std::string text = Scene(integrator, "", samples);
    text.replace(text.find(kCard), std::string(kCard).size(), card);
    text.insert(text.find("WorldBegin") + std::string("WorldBegin").size(), " " + parts);
    return head + text;
}
/// All channels of the columns [begin, kSize).
void ExpectSameBits(const Image& a, const Image& b, int begin, const std::string& what) {
    for (int y = 0; y < kSize; ++y)
        for (int x = begin; x < kSize; ++x)
            for (int c = 0; c < a.NumChannels(); ++c)
                ASSERT_EQ(a.Get({x, y}, c), b.Get({x, y}, c)) << what << ' ' << x << ' ' << y << ' ' << c;
}
std::string Fog(const std::string& parameters) {
    return R"(MakeNamedMedium "fog" "string type" "homogeneous" )" + parameters +
           R"( MediumInterface "" "fog" )";
}

/// A medium that absorbs and glows: what lies before the card stays, and so does its part of alpha, both in
/// closed form: 1 - exp(-sigma t) of its own radiance along the ray, with t up to the card.
TEST(HoldoutInMedia, KeepsTheLightBeforeIt) {
    const double sigma = 0.4;
    const auto scene = [&](const char* glow) {
        return Fog(fmt::format(
            R"("rgb sigma_a" [{0} {0} {0}] "rgb sigma_s" [0 0 0] "float Lescale" {1} "rgb Le" [1 1 1])",
            sigma, glow));
    };
    const std::string card = fmt::format("{} {}", kCard, kHoldout),
                      volpath = R"("volpath" "integer maxdepth" 4)";
    const auto held = RenderedText(SceneOf(volpath, card, 64, "", scene("1")), false);
    const auto seen = RenderedText(SceneOf(volpath, kCard, 64, "", scene("1")), false);
    ExpectSameBits(*held, *seen, kSize / 2, volpath);
    test::RunningMean quotient;
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize / 2; ++x) {
            // The card is at depth 2; a field of view of 90 degrees.
            const double u = (x + 0.5) * 2 / kSize - 1, v = (y + 0.5) * 2 / kSize - 1;
            const double covered = 1 - std::exp(-sigma * 2 * std::sqrt(1 + u * u + v * v));
            EXPECT_NEAR(held->Get({x, y}, held->FindChannel("A")), covered, 1e-3) << x << ' ' << y;
            EXPECT_EQ(held->Get({x, y}, held->FindChannel("Z")), 0);
            quotient.Add(test::LuminanceAt(*held, {x, y}) / covered);
        }
    // The same radiance everywhere: but for the noise of wavelengths, which all pixels have alike.
    EXPECT_GT(quotient.Mean(), 0);
    EXPECT_LT(quotient.StandardError(), 0.02 * quotient.Mean());
    EXPECT_LT(SumOf(*held, 0, kSize / 2).light, SumOf(*seen, 0, kSize / 2).light);
    // Without glow nothing is left.
    EXPECT_EQ(SumOf(*RenderedText(SceneOf(volpath, card, 8, "", scene("0"))), 0, kSize / 2).light, 0);
}

/// A medium that scatters: all samples but those that meet the card first are the same. The scattered light
/// still meets the card.
TEST(HoldoutInMedia, IsSeenByScatteredLight) {
    const std::string fog = Fog(R"("rgb sigma_a" [.05 .05 .05] "rgb sigma_s" [.3 .3 .3])");
    const std::string volpath = R"("volpath" "integer maxdepth" 4)";
    const std::string black = R"(Material "diffuse" "rgb reflectance" [0 0 0])";
    const auto seen = RenderedText(SceneOf(volpath, kCard, 32, "", fog));
    const auto held = RenderedText(SceneOf(volpath, fmt::format("{} {}", kCard, kHoldout), 32, "", fog));
    ExpectSameBits(*held, *seen, kSize / 2, "fog");
    const Part left = SumOf(*held, 0, kSize / 2), whole = SumOf(*seen, 0, kSize / 2);
    EXPECT_GT(left.light, 0.05 * whole.light);
    EXPECT_LT(left.light, 0.8 * whole.light);
    // 1 - exp(-0.35 t) with t from 2 to 3.5.
    EXPECT_GT(left.alpha, 0.45 * whole.alpha);
    EXPECT_LT(left.alpha, 0.75 * whole.alpha);
    // The card's own light is in the fog before it: with a card that does not shine there is less.
    std::string dark = SceneOf(volpath, fmt::format("{} {}", black, kHoldout), 32, "", fog);
    const std::string lamp = R"("rgb L" [2 1 1])";
    dark.replace(dark.find(lamp), lamp.size(), R"("rgb L" [.001 0 0])");
    EXPECT_LT(SumOf(*RenderedText(dark), 0, kSize / 2).light, 0.9 * left.light);
}

/// Cards below whose surface light scatters, stacks, and mixtures.
TEST(HoldoutMaterials, OfAllKindsAreHoles) {
    const std::string parts = R"(MakeNamedMaterial "a" "string type" "diffuse"
        MakeNamedMaterial "b" "string type" "coateddiffuse" )";
    for (const char* card : {R"(Material "subsurface" "rgb mfp" [.3 .2 .1] "rgb reflectance" [.7 .5 .3])",
                             R"(Material "coateddiffuse")", R"(Material "dielectric")",
                             R"(Material "mix" "string materials" ["a" "b"])"})
        for (const char* integrator :
             {R"("path" "integer maxdepth" 4)", R"("volpath" "integer maxdepth" 4)"}) {
            const auto seen = RenderedText(SceneOf(integrator, card, 8, parts));
            const auto held =
                RenderedText(SceneOf(integrator, fmt::format("{} {}", card, kHoldout), 8, parts));
            EXPECT_GT(SumOf(*seen, 0, kSize / 2).light, 0) << card;
            EXPECT_EQ(SumOf(*held, 0, kSize / 2).light, 0) << card;
            EXPECT_EQ(SumOf(*held, 0, kSize / 2).alpha, 0) << card;
            ExpectSameBits(*held, *seen, kSize / 2, card);
        }
}
/// What scatters below its surface behind and beside a holdout is as it was.
TEST(HoldoutMaterials, LeaveSubsurfaceScatteringAlone) {
    const std::string wall = R"(Material "diffuse" "rgb reflectance" [.7 .7 .2])";
    const auto scene = [&](const char* holdout) {
        std::string text =
            SceneOf(R"("volpath" "integer maxdepth" 6)", fmt::format("{} {}", kCard, holdout), 16);
        return text.replace(text.find(wall), wall.size(),
                            R"(Material "subsurface" "rgb mfp" [.3 .2 .1] "rgb reflectance" [.7 .5 .3])");
    };
    const auto seen = RenderedText(scene("")), held = RenderedText(scene(kHoldout));
    EXPECT_EQ(SumOf(*held, 0, kSize / 2).light, 0);
    ExpectSameBits(*held, *seen, kSize / 2, "wall");
}

/// Mixtures under integrators that trace from the light, whose connections to the camera must not show one.
TEST(HoldoutBidirectional, OfAMixtureIsAHole) {
    const std::string parts = fmt::format(
        R"(MakeNamedMaterial "a" "string type" "diffuse" {0} MakeNamedMaterial "b" "string type" "diffuse" )",
        kHoldout);
    const std::string mix = R"(Material "mix" "string materials" ["b" "b"])",
                      mixOfHoldouts = R"(Material "mix" "string materials" ["a" "a"])";
    for (const char* integrator : {R"("bdpt" "integer maxdepth" 4)", R"("lightpath" "integer maxdepth" 4)"}) {
        const auto leftOf = [&](const std::string& card) {
            return SumOf(*RenderedText(SceneOf(integrator, card, 32, parts)), 0, kSize / 2);
        };
        EXPECT_EQ(leftOf(fmt::format("{} {}", mix, kHoldout)).light, 0) << integrator;
        EXPECT_EQ(leftOf(fmt::format("{} {}", mix, kHoldout)).alpha, 0) << integrator;
        // Its parts have no say.
        EXPECT_GT(leftOf(mixOfHoldouts).light, 1) << integrator;
        EXPECT_EQ(leftOf(mixOfHoldouts).alpha, kSize * kSize / 2) << integrator;
    }
    const std::string bdpt = R"("bdpt" "integer maxdepth" 4)";
    const auto seen = RenderedText(SceneOf(bdpt, mix, 100, parts));
    const auto held = RenderedText(SceneOf(bdpt, fmt::format("{} {}", mix, kHoldout), 100, parts));
    ExpectSameMeanOnTheRight(*seen, *held, 0.015);
}

/// Of every light group, and the card's own light is still what others get of it.
TEST(HoldoutInPasses, HoldsOutEveryLightGroup) {
    const auto image = [&](const std::string& integrator, const char* holdout) {
        std::string text = SceneOf(integrator, fmt::format("{} {}", kCard, holdout), 16);
        for (const auto& [light, group] :
             {std::pair(R"("rgb L" [2 1 1])", "card"), {R"("rgb L" [9 9 9])", "lamp"}})
            text.insert(text.find(light), fmt::format("\"string group\" \"{}\" ", group));
        const RenderSetup setup = test::BuildText(text);
        const auto passes = MakePasses({"lightgroups"}, setup);
        RenderOptions options;
        options.passes = passes.get();
        test::RenderAll(setup, options);
        return setup.film->AppendPasses(*setup.film->Develop());
    };
    for (const char* integrator : {R"("path" "integer maxdepth" 4)", R"("volpath" "integer maxdepth" 4)"}) {
        const auto seen = image(integrator, ""), held = image(integrator, kHoldout);
        ASSERT_EQ(seen->NumChannels(), 12);
        ExpectSameBits(*held, *seen, kSize / 2, integrator);
        double cardOnTheRight = 0;
        for (int y = 0; y < kSize; ++y)
            for (int x = 0; x < kSize; ++x)
                for (int c = 0; c < 12; ++c)
                    if (x < kSize / 2)
                        ASSERT_EQ(held->Get({x, y}, c), 0) << integrator << x << y << c;
                    else if (c == held->FindChannel("lightgroup.card.R"))
                        cardOnTheRight += double(held->Get({x, y}, c));
        EXPECT_GT(cardOnTheRight, 0.1) << integrator;
    }
}

}  // namespace
}  // namespace lacquer::holdout_test
