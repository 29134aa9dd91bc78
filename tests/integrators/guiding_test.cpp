// Guided paths find the images of paths that are not, whatever they scatter by; with less noise where light
// is hard to find; and the same bits whatever the threads and the part of the image.
#include <gtest/gtest.h>

#include "integrators/image_agreement.h"
#include "integrators/render_fixtures.h"
#include "pbrt/core/parallel.h"
#include "pbrt/integrators/guide_plan.h"
#include "pbrt/integrators/guide_trial.h"

namespace lacquer::guiding_test {
namespace {

using test::CompareRenders;
using test::FullTestName;
using test::Passes;
using test::RenderText;

constexpr double kAlpha = 1e-5;

std::string Text(const std::string& world, bool guides, uint64_t seed, const std::string& integrator = "path",
                 int samples = 128, const std::string& film = "", Int2 size = {16, 16}) {
    return "LookAt 0 1.2 -2.9  0 1 0  0 1 0 Camera \"perspective\" \"float fov\" 60 Film \"rgb\" "
           "\"integer xresolution\" " +
           std::to_string(size.x) + " \"integer yresolution\" " + std::to_string(size.y) + film +
           " PixelFilter \"box\" Sampler \"independent\" \"integer pixelsamples\" " +
           std::to_string(samples) + " \"integer seed\" " + std::to_string(seed % 100000000) +
           " Integrator \"" + integrator + "\" \"integer maxdepth\" 5 \"bool guiding\" " +
           (guides ? "true" : "false") + " WorldBegin " + world;
}
std::string Patch(const std::string& corners) {
    return " Shape \"bilinearmesh\" \"point3 P\" [" + corners + "]";
}
/// A room from within, at whose far end light comes around a screen.
std::string Room(const std::string& material, double screen = 1.5) {
    const std::string edge = std::to_string(screen);
    return " AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [40 30 20] Translate 0 1.2 3.5 Rotate 180 "
           "0 1 0 Shape \"disk\" \"float radius\" 0.4 AttributeEnd Material " +
           material + Patch("-2 0 -3  2 0 -3  -2 0 4  2 0 4") +
           Patch("-2 2.5 -3  2 2.5 -3  -2 2.5 4  2 2.5 4") + Patch("-2 0 -3  -2 0 4  -2 2.5 -3  -2 2.5 4") +
           Patch("2 0 -3  2 0 4  2 2.5 -3  2 2.5 4") + Patch("-2 0 4  2 0 4  -2 2.5 4  2 2.5 4") +
           " Material \"diffuse\" \"rgb reflectance\" [.2 .5 .7]" +
           Patch("-2 0 1  " + edge + " 0 1  -2 2.5 1  " + edge + " 2.5 1");
}
const std::string kMatte = "\"diffuse\" \"rgb reflectance\" [.7 .6 .5]";
const std::string kBall =
    " AttributeBegin Translate -0.4 0.5 -0.5 Shape \"sphere\" \"float radius\" 0.5 AttributeEnd";

const std::string kFog =
    " MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [.01 .02 .05] "
    "\"rgb sigma_s\" [.1 .2 .4] \"float g\" 0.4 AttributeBegin MediumInterface \"fog\" \"\" "
    "Material \"interface\" Translate 0 1 0 Shape \"sphere\" \"float radius\" 1.5 AttributeEnd";

/// A guide is used whatever its trial says: of few samples, it would not be worth its time.
RenderOptions WithoutTrial() {
    RenderOptions options;
    options.triesGuide = false;
    return options;
}
test::Rendering RenderingOf(const std::string& world, bool guides, const std::string& integrator,
                            int samples) {
    return {guides ? "guided" : "not guided",
            [=](uint64_t seed) { return Text(world, guides, seed, integrator, samples); }, WithoutTrial()};
}
void ExpectAgreement(const std::string& world, const std::string& integrator = "path", int samples = 128) {
    const RenderSetup setup = test::BuildText(Text(world, true, 1, integrator, samples));
    EXPECT_TRUE(test::RenderAll(setup, WithoutTrial()).wasGuided);
    EXPECT_TRUE(Passes(FullTestName(), kAlpha, [&](uint64_t seed) {
        return CompareRenders(RenderingOf(world, false, integrator, samples),
                              RenderingOf(world, true, integrator, samples), 1, seed);
    }));
}

// Power: the standard error of the whole image is 0.2 to 0.5 %, that of blocks 11 % at most; of renders of
// guides that have learned little and unevenly, where a wrong density would show most. The control is off by
// 10 %.
TEST(Guiding, FindsTheImageOfDiffuseWalls) { ExpectAgreement(Room(kMatte)); }
TEST(Guiding, FindsTheImageOfLayers) {
    ExpectAgreement(Room("\"coateddiffuse\" \"rgb reflectance\" [.7 .6 .5] \"float roughness\" 0.3"));
}
// By a walk of its own for each density, which may come to nothing.
TEST(Guiding, FindsTheImageOfLayersWithEstimatedDensities) {
    ExpectAgreement(
        Room("\"coateddiffuse\" \"rgb reflectance\" [.7 .6 .5] \"float roughness\" 0.3 "
             "\"string pdf\" \"unbiased\""));
}
// Glossy beside smooth: lobes of which the guide cannot draw.
TEST(Guiding, FindsTheImageOfGlossAndGlass) {
    ExpectAgreement(
        Room(kMatte) + " Material \"dielectric\" \"float roughness\" 0.2" + kBall +
            " Material \"coateddiffuse\" \"rgb reflectance\" [.7 .6 .5] \"float roughness\" 0"
            " AttributeBegin Translate 1.2 1 0 Shape \"sphere\" \"float radius\" 0.7 AttributeEnd",
        "path", 512);
}
TEST(Guiding, FindsTheImageOfBothSides) {
    ExpectAgreement(
        Room("\"diffusetransmission\" \"rgb reflectance\" [.4 .3 .2] \"rgb transmittance\" [.2 .3 .4]") +
        " Material \"conductor\" \"float roughness\" 0.3" + kBall);
}
// Colours that differ in extinction, and in the volume as on surfaces.
TEST(Guiding, FindsTheImageOfColouredFog) { ExpectAgreement(kFog + Room(kMatte), "volpath"); }
TEST(Guiding, NegativeControlTenPerCentAreFound) {
    const std::string world = Room(kMatte, 0);
    EXPECT_LT(CompareRenders(RenderingOf(world, false, "path", 128), RenderingOf(world, true, "path", 128),
                             1.1, test::SeedOf(FullTestName()))
                  .pValue,
              kAlpha);
}

/// Mean over the pixels of what two renders differ by, relative to what they have in common.
double NoiseOf(const std::string& world, bool guides) {
    constexpr Int2 kResolution(48, 36);
    const auto image = [&](uint64_t seed) {
        const RenderSetup setup =
            test::BuildText(Text(world, guides, seed, "path", test::Scaled(256), "", kResolution));
        test::RenderAll(setup, WithoutTrial());
        return setup.film->Develop();
    };
    const auto a = image(1), b = image(2);
    test::RunningMean noise;
    for (int y = 0; y < kResolution.y; ++y)
        for (int x = 0; x < kResolution.x; ++x) {
            const double p = test::LuminanceAt(*a, {x, y}), q = test::LuminanceAt(*b, {x, y});
            noise.Add(Sqr((p - q) / (p + q + 1e-4)));
        }
    return noise.Mean();
}
// What it is for: where light comes through a gap of a tenth of the room. Of four pairs of seeds, the
// quotient was 0.47 to 0.53.
TEST(Guiding, LeavesLessNoiseBehindAScreen) {
    const std::string world = Room(kMatte, 1.6);
    EXPECT_LT(NoiseOf(world, true), (test::Scaled(256) < 256 ? 1.2 : 0.7) * NoiseOf(world, false));
}

TEST(Guiding, DoesNotDependOnThreads) {
    const auto render = [&](int threads) {
        const ThreadLimit limit(threads);
        const RenderSetup setup =
            test::BuildText(Text(kFog + Room(kMatte), true, 3, "volpath", 64, "", {40, 33}));
        EXPECT_TRUE(test::RenderAll(setup, WithoutTrial()).wasGuided);
        return setup.film->Develop();
    };
    const auto one = render(1);
    for (const int threads : {2, 3}) EXPECT_EQ(one->Pixels(), render(threads)->Pixels()) << threads;
}
TEST(Guiding, DoesNotDependOnThePartOfTheImage) {
    const auto render = [](const std::string& bounds) {
        const RenderSetup setup =
            test::BuildText(Text(kFog + Room(kMatte), true, 3, "volpath", 64, bounds, {40, 33}));
        EXPECT_TRUE(test::RenderAll(setup, WithoutTrial()).wasGuided);
        return setup.film->Develop();
    };
    const auto whole = render(""), part = render(" \"integer pixelbounds\" [7 20 11 30]");
    ASSERT_EQ(part->Resolution(), Int2(13, 19));
    EXPECT_EQ(whole->Part({{7, 11}, {20, 30}}, {0, 1, 2}).Pixels(),
              part->Part({{0, 0}, {13, 19}}, {0, 1, 2}).Pixels());
}
// What it learns from: at least 16 samples of a pixel, at most a quarter of all, and 2^23.
TEST(GuidePlan, IsOfAQuarterOfTheSamplesAtMost) {
    for (const Int2 resolution :
         {Int2(1, 1), Int2(3, 500), Int2(640, 480), Int2(3840, 2160), Int2(40000, 30000)})
        for (const int samples : {1, 15, 16, 17, 64, 1000, 100000}) {
            const GuidePlan plan(resolution, samples);
            const int64_t all = int64_t(resolution.x) * resolution.y * samples;
            if (samples < 16 || all / 4 < 16) {
                EXPECT_EQ(plan.NumPasses(), 0) << samples;
                continue;
            }
            ASSERT_GE(plan.NumPasses(), 5) << resolution.x << " x " << resolution.y << ", " << samples;
            EXPECT_LE(plan.NumSamples(), std::min(all / 4, int64_t(1) << 23));
            EXPECT_LE(GuidePlan::EndSample(plan.NumPasses() - 1), samples);
            const Int2 last = plan.Blocks().max - 1;
            const Int2 pixel = plan.PixelIn(last, Rng(1)), first = plan.PixelIn({0, 0}, Rng(2));
            EXPECT_TRUE((Bounds2i{Int2(0), resolution}.Contains(pixel)));
            EXPECT_TRUE((Bounds2i{Int2(0), resolution}.Contains(first)));
        }
}
TEST(GuidePlan, HasPassesThatFollowEachOther) {
    EXPECT_EQ(GuidePlan::FirstSample(0), 0);
    for (int pass = 0; pass < 10; ++pass)
        EXPECT_EQ(GuidePlan::EndSample(pass), GuidePlan::FirstSample(pass + 1)) << pass;
    EXPECT_EQ(GuidePlan::EndSample(9), 512);
}

/// Whether a guide is worth it whose means of two samples differ by `guided`, those without it by 1, in one
/// tile about `mean`.
bool IsWorthIt(double guided, double mean) {
    GuideTrial trial;
    GuideTrial::Tile tile;
    for (int i = 0; i < 10; ++i) {
        GuideTrial::Pixel pixel;
        for (const int block : {0, 1})
            for (int sample = 0; sample < 2; ++sample) {
                pixel.Add(false, block, float(mean + block));
                pixel.Add(true, block, float(mean + block * guided));
            }
        tile.Add(pixel);
    }
    trial.Add(tile);
    return trial.IsWorthIt();
}
TEST(GuideTrial, AsksForTwoAndAHalfTimesLessVariance) {
    for (const double mean : {0.5, 10., 100.}) {
        EXPECT_TRUE(IsWorthIt(std::sqrt(1 / 2.6), mean)) << mean;
        EXPECT_FALSE(IsWorthIt(std::sqrt(1 / 2.4), mean)) << mean;
    }
    EXPECT_TRUE(GuideTrial().IsWorthIt()) << "nobody has tried";
}
TEST(GuideTrial, LeavesOutWhatIsNoNumber) {
    GuideTrial trial;
    GuideTrial::Tile tile;
    for (const float light : {std::numeric_limits<float>::infinity(), std::nanf("")}) {
        GuideTrial::Pixel pixel;
        for (const int block : {0, 1})
            for (const bool isGuided : {false, true}) pixel.Add(isGuided, block, light);
        tile.Add(pixel);
    }
    trial.Add(tile);
    EXPECT_TRUE(trial.IsWorthIt());
}

// A trial rejects a guide where it is not worth its time, and takes it where it is.
TEST(Guiding, IsTried) {
    const auto wasGuided = [](const std::string& world, int samples) {
        const RenderSetup setup = test::BuildText(Text(world, true, 3, "path", samples, "", {48, 36}));
        return test::RenderAll(setup).wasGuided;
    };
    const std::string sky = " LightSource \"infinite\" \"rgb L\" [1 2 3]";
    EXPECT_FALSE(wasGuided(sky + " Material " + kMatte + kBall, test::Scaled(256)));
    if (test::Scaled(1024) == 1024) {
        EXPECT_TRUE(wasGuided(Room(kMatte, 1.6), 1024));
    }
}
TEST(Guiding, IsOffByDefault) {
    std::string text = Text(Room(kMatte), false, 3);
    const auto off = RenderText(text);
    text.erase(text.find(" \"bool guiding\" false"), 21);
    EXPECT_EQ(off->Pixels(), RenderText(text)->Pixels());
}
// Too few to learn anything from: nothing is followed that does not count.
TEST(Guiding, IsOffWithFewSamples) {
    EXPECT_EQ(RenderText(Text(Room(kMatte), true, 3, "path", 4))->Pixels(),
              RenderText(Text(Room(kMatte), false, 3, "path", 4))->Pixels());
}
// No light, no surface, no extent.
TEST(Guiding, RendersScenesWithNothingToLearn) {
    for (const std::string& world :
         {std::string(), std::string(" LightSource \"infinite\" \"rgb L\" [1 2 3]"),
          " Material " + kMatte + kBall}) {
        EXPECT_EQ(RenderText(Text(world, true, 3))->Pixels(), RenderText(Text(world, false, 3))->Pixels());
    }
}

}  // namespace
}  // namespace lacquer::guiding_test
