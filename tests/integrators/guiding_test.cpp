// Guided paths find the images of paths that are not, whatever they scatter by; with less noise where light
// is hard to find; and the same bits whatever the threads and the part of the image.
#include <gtest/gtest.h>

#include <set>

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
TEST(Guiding, FindsTheImageOfDiffuseWalls) { ExpectAgreement(Room(kMatte), "path", 256); }
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
// What it learns from: at least 16 samples of a pixel, at most an eighth of all, and 2^23.
TEST(GuidePlan, IsOfAnEighthOfTheSamplesAtMost) {
    for (const Int2 resolution :
         {Int2(1, 1), Int2(3, 500), Int2(640, 480), Int2(3840, 2160), Int2(40000, 30000)})
        for (const int samples : {1, 15, 16, 17, 64, 1000, 100000}) {
            const GuidePlan plan(resolution, samples);
            const int64_t all = int64_t(resolution.x) * resolution.y * samples;
            if (samples < 16 || all / 8 < 16) {
                EXPECT_EQ(plan.NumPasses(), 0) << samples;
                continue;
            }
            ASSERT_GE(plan.NumPasses(), 5) << resolution.x << " x " << resolution.y << ", " << samples;
            EXPECT_LE(plan.NumSamples(), std::min(all / 8, int64_t(1) << 23));
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

/// A trial of sets of 8 samples; those without a guide differ by `without` in the mean, and those with one by
/// `guided`, in this direction and that.
GuideTrial TrialOf(float without, float guided, float mean, int learned = 0, float first = 0) {
    constexpr int kSamples = 8;
    GuideTrial trial({400, 320}, 3);
    for (size_t k = 0; k < trial.NumPixels(); ++k)
        for (int set = 0; set < GuideTrial::kSets; ++set) {
            const float side = 0.5f - 0.5f * float(set);  // the one in the middle is the mean
            const auto sum = [&](int samples, float difference, const RGB& colour) {
                return glm::dvec3(float(samples) * (RGB(mean) + side * difference * colour));
            };
            const glm::dvec3 part = sum(learned, first, RGB(1, 2, 3));
            const glm::dvec3 rest = sum(kSamples, without, RGB(1, 2, 3)) - part;
            trial.SetOf(k, set) = {part, rest,
                                   sum(kSamples - learned, k % 2 ? guided : -guided, RGB(3, 2, 1))};
        }
    return trial;
}
TEST(GuideTrial, ComparesVariances) {
    for (const float mean : {0.5f, 10.f, 1e6f, 1e15f}) {
        EXPECT_NEAR(TrialOf(0.2f * mean, 0.1f * mean, mean).GainOfGuide().value, 4, 1e-3) << mean;
        EXPECT_NEAR(TrialOf(0.1f * mean, 0.2f * mean, mean).GainOfGuide().value, 0.25, 1e-3) << mean;
    }
    EXPECT_EQ(TrialOf(0, 0, 1).GainOfGuide().value, 1);
    EXPECT_EQ(TrialOf(0, 0, 0).GainOfGuide().value, 1);
    EXPECT_GT(TrialOf(1, 0, 1).GainOfGuide().value, 1e5);
}
/// Of 8 samples 2 were learned from: their mean has a quarter of the weight, and the variance that so few
/// have without a guide.
TEST(GuideTrial, CountsSamplesThatWereLearnedFrom) {
    EXPECT_NEAR(TrialOf(0.2f, 0.1f, 1, 2, 0.4f).GainOfGuide().value, 0.04 / (0.16 / 16 + 0.01 * 9 / 16), 0.1);
    EXPECT_NEAR(TrialOf(0.2f, 0.2f, 1, 2, 0.4f).GainOfGuide().value, 0.04 / (0.16 / 16 + 0.04 * 9 / 16), 0.1);
}
/// Pixels whose sets found nothing without a guide, or much, count as much as others. By the mean of those
/// sets alone the guide would lose, 0.3 to 1.
TEST(GuideTrial, FindsAGuideThatFindsRareLight) {
    Rng rng(test::SeedOf(FullTestName()));
    GuideTrial trial({400, 320}, 3);
    for (size_t k = 0; k < trial.NumPixels(); ++k)
        for (int set = 0; set < GuideTrial::kSets; ++set) {
            const double rare = rng.Uniform() < 0.3f ? 1 / 0.3 : 0,
                         guided = 0.25 + 1.5 * double(rng.Uniform());
            trial.SetOf(k, set) = {glm::dvec3(0), glm::dvec3(rare), glm::dvec3(guided)};
        }
    EXPECT_GT(trial.GainOfGuide().value, 3) << "of 12";
}
/// Sets of a pixel that differ by this much without a guide, and with one.
void SetDifferences(GuideTrial* trial, size_t k, double without, double guided) {
    const glm::dvec3 mean(1000);  // so that relative to it no difference counts more than others
    trial->SetOf(k, 0) = {glm::dvec3(0), mean + without, mean + guided};
    trial->SetOf(k, 1) = {glm::dvec3(0), mean, mean};
    trial->SetOf(k, 2) = {glm::dvec3(0), mean - without, mean - guided};
}
/// Variances that are draws from exponential distributions, by n pixels: the logarithm of the quotient of
/// independent sums has a standard deviation of (2 / n)^0.5. It is less where numerator and denominator
/// are correlated, and large where one pixel has most of both.
TEST(GuideTrial, TellsHowWellItKnowsTheGain) {
    Rng rng(test::SeedOf(FullTestName()));
    const auto draw = [&] { return std::sqrt(-2 * std::log(1 - double(rng.Uniform()))); };
    test::RunningMean logarithm, error, ofCorrelated, ofOne;
    int below = 0;
    for (int i = 0; i < 300; ++i) {
        GuideTrial independent({400, 320}, 3), correlated({400, 320}, 3);
        for (size_t k = 0; k < independent.NumPixels(); ++k) {
            const double without = draw();
            SetDifferences(&independent, k, without, draw());
            SetDifferences(&correlated, k, without, without / 2);
        }
        const GuideTrial::Gain gain = independent.GainOfGuide();
        logarithm.Add(std::log(gain.value));
        error.Add(gain.logError);
        below += gain.AtLeast() < 1;
        EXPECT_NEAR(correlated.GainOfGuide().value, 4, 1e-3);
        ofCorrelated.Add(correlated.GainOfGuide().logError);
        SetDifferences(&independent, 0, 100, 45);
        ofOne.Add(independent.GainOfGuide().logError);
    }
    const double expected = std::sqrt(2 / double(GuideTrial({400, 320}, 3).NumPixels()));
    EXPECT_NEAR(error.Mean(), expected, 0.05 * expected);
    EXPECT_NEAR(std::sqrt(logarithm.Variance()), expected, 0.2 * expected) << "five standard errors";
    EXPECT_LT(ofCorrelated.Mean(), 1e-3);
    EXPECT_GT(ofOne.Mean(), 1) << "of a gain of 3.5, which the others do not have";
    EXPECT_NEAR(below, 200, 41) << "two times in three, give or take five standard errors";
}
TEST(GuideTrial, CountsWhatGuidedSamplesCost) {
    GuideTrial trial = TrialOf(0.2f, 0.1f, 1);
    EXPECT_EQ(trial.GainOfGuide().cost, 1) << "no ray, no difference";
    for (size_t k = 0; k < trial.NumPixels(); ++k)
        for (int set = 0; set < GuideTrial::kSets; ++set) {
            trial.SetOf(k, set).rays = {100, 60};
            trial.SetOf(k, set).guidedRays = {120, 76};
        }
    EXPECT_NEAR(trial.GainOfGuide().cost, (1.7 * 120 + 76) / 160, 1e-12);
}
TEST(GuideTrial, CountsDarkPixelsByTheMean) {
    GuideTrial uneven = TrialOf(0.1f, 0.1f, 1);
    for (int set = 0; set < GuideTrial::kSets; ++set)
        uneven.SetOf(0, set) = {glm::dvec3(0), glm::dvec3(1e-3 + 1e-2 * set), glm::dvec3(1e-3)};
    EXPECT_NEAR(uneven.GainOfGuide().value, 1, 0.01) << "relative to itself, it would have most of the noise";
}
TEST(GuideTrial, LeavesOutWhatIsNoNumber) {
    for (const double light : {std::numeric_limits<double>::infinity(), std::nan("")})
        for (const bool isGuided : {false, true}) {
            GuideTrial trial = TrialOf(0.2f, 0.1f, 1);
            const glm::dvec3 bad(0, light, 0), good(1);
            trial.SetOf(5, 1) = {glm::dvec3(0), isGuided ? good : bad, isGuided ? bad : good};
            EXPECT_NEAR(trial.GainOfGuide().value, 4, 1e-3);
        }
}
TEST(GuideTrial, ItsPixelsAreSpreadAndHaveNumbersOfOthers) {
    for (const Int2 size : {Int2(1, 1), Int2(3, 2), Int2(4000, 1), Int2(1, 4000), Int2(640, 481),
                            Int2(7680, 3), Int2(16384, 16384)}) {
        const GuideTrial trial(size, 7);
        EXPECT_GE(trial.NumPixels(), 16u);
        EXPECT_LE(trial.NumPixels(), 1024u);
        size_t left = 0;
        for (size_t k = 0; k < trial.NumPixels(); ++k) {
            const Int2 place = trial.PixelAt(k);
            left += place.x < size.x / 2;
            std::set<std::pair<int, int>> pixels = {{place.x, place.y}};
            for (int set = 0; set < GuideTrial::kSets; ++set) {
                const Int2 numbers = trial.NumbersOf(k, set);
                EXPECT_TRUE((Bounds2i{Int2(0), size}.Contains(numbers)));
                pixels.insert({numbers.x, numbers.y});
            }
            EXPECT_EQ(pixels.size(), size == Int2(1) ? 1 : size_t(GuideTrial::kSets) + 1);
        }
        if (size.x > 100) {
            EXPECT_NEAR(double(left) / double(trial.NumPixels()), 0.5, 0.05);
        }
        // All sets of all pixels by both ways are a twentieth of the image's samples at most.
        for (const int samples : {1, 64, 4096, 1 << 24}) {
            const double followed =
                2. * GuideTrial::kSets * double(trial.NumPixels()) * trial.MostSamples(samples);
            EXPECT_LE(followed, 0.05 * samples * double(size.x) * size.y);
            EXPECT_LE(trial.MostSamples(samples), samples);
        }
        EXPECT_EQ(trial.MostSamples(256), size.x * size.y > 100 ? 256 : 0);
    }
}

// A trial rejects a guide where it is not worth its time, and takes it where it is.
TEST(Guiding, IsTried) {
    const auto wasGuided = [](const std::string& world, int samples, Int2 size) {
        const RenderSetup setup = test::BuildText(Text(world, true, 3, "path", samples, "", size));
        return test::RenderAll(setup).wasGuided;
    };
    const std::string sky = " LightSource \"infinite\" \"rgb L\" [1 2 3]";
    EXPECT_FALSE(wasGuided(sky + " Material " + kMatte + kBall, test::Scaled(256), {48, 36}));
    if (test::Scaled(512) == 512) {
        EXPECT_TRUE(wasGuided(Room(kMatte, 1.6), 512, {120, 90})) << "by 49 pixels";
    }
}
/// Whether a guide is taken is told by the whole image alone.
TEST(Guiding, TrialsAreTheSameWhateverThreadsAndParts) {
    const std::string text = Text(Room(kMatte, 1.6), true, 3, "path", 256, "", {48, 36});
    const auto render = [&](int threads, RenderOptions options, bool* wasGuided) {
        const ThreadLimit limit(threads);
        const RenderSetup setup = test::BuildText(text);
        options.plannedSamples = 256;
        *wasGuided = test::RenderAll(setup, options).wasGuided;
        return setup.film->Develop()->Pixels();
    };
    bool first = false, second = false;
    EXPECT_EQ(render(1, {}, &first), render(3, {}, &second));
    EXPECT_EQ(first, second);
    // The same scene with what it has learned is guided where nobody asks.
    render(2, WithoutTrial(), &second);
    EXPECT_TRUE(second);
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
