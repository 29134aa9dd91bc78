// Metropolis light transport finds the images of other integrators, whatever the threads, and says where
// there is nothing to find. That its chains are right is in primary_samples_test.cpp; that images of every
// light and material agree, in bidirectional_test.cpp.
#include <gtest/gtest.h>

#include <atomic>

#include "integrators/image_agreement.h"
#include "integrators/render_fixtures.h"
#include "pbrt/core/parallel.h"
#include "pbrt/film/aov.h"
#include "pbrt/integrators/rendered_image.h"

namespace lacquer::mlt_test {
namespace {

using test::FullTestName;
using test::Outcome;
using test::Passes;
using test::RenderText;
using test::RunningMean;
using test::SeedOf;

constexpr double kAlpha = 1e-5;
constexpr int kSize = 16;

/// An integrator with its parameters but for maxdepth, and the samples per pixel it takes.
struct Method {
    std::string name;
    int samples;
    std::string parameters = {};
};
Method Mlt(int mutations, int bootstrap = 1000, int chains = 64) {
    return {"mlt", mutations,
            " \"integer bootstrapsamples\" " + std::to_string(bootstrap) + " \"integer chains\" " +
                std::to_string(chains)};
}

std::string Text(const std::string& world, const Method& method, int depth, uint64_t seed,
                 const std::string& film = "") {
    const std::string count = std::to_string(method.samples);
    return "LookAt 0 1 -4  0 0 0  0 1 0 Camera \"perspective\" \"float fov\" 40 Film \"rgb\" \"integer "
           "xresolution\" " +
           std::to_string(kSize) + " \"integer yresolution\" " + std::to_string(kSize) + film +
           " PixelFilter \"box\" Sampler \"independent\" \"integer pixelsamples\" " + count +
           " \"integer seed\" " + std::to_string(seed % 100000000) + " Integrator \"" + method.name +
           "\" \"integer maxdepth\" " + std::to_string(depth) + method.parameters +
           (method.name == "mlt" ? " \"integer mutationsperpixel\" " + count : "") + " WorldBegin " + world;
}

std::string Disk(const std::string& placed, const std::string& radius = "3") {
    return " AttributeBegin " + placed + " Shape \"disk\" \"float radius\" " + radius + " AttributeEnd";
}
const std::string kFloor =
    " Material \"diffuse\" \"rgb reflectance\" [.6 .6 .6]" + Disk("Translate 0 -1 0 Rotate -90 1 0 0");
const std::string kLamp =
    " AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [25 25 25] \"bool twosided\" true "
    "Translate 0.5 2.2 -0.5 Shape \"sphere\" \"float radius\" 0.3 AttributeEnd";
std::string Ball(const std::string& material) {
    return " AttributeBegin Material " + material +
           " Translate -0.4 -0.3 0 Shape \"sphere\" \"float radius\" 0.7 AttributeEnd";
}
const std::string kMatteRoom = kLamp + kFloor + Ball("\"diffuse\" \"rgb reflectance\" [.7 .4 .2]");
const std::string kGlossyRoom = kLamp + kFloor + Ball("\"conductor\" \"float roughness\" 0.15");
const std::string kGlassRoom = kLamp + kFloor + Ball("\"dielectric\"");
/// Under a sky that the camera sees.
const std::string kOpenAir =
    "LightSource \"infinite\" \"rgb L\" [.5 .5 .5]" + kFloor + Ball("\"dielectric\"");
/// A small lamp, whose caustic on the floor paths from the camera hardly find.
const std::string kCaustic =
    " AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [400 400 400] \"bool twosided\" true "
    "Translate -0.4 2 0 Rotate 90 1 0 0 Shape \"disk\" \"float radius\" 0.05 AttributeEnd" +
    kFloor + Ball("\"dielectric\"");
/// The same by glass that parts colours.
const std::string kDispersion =
    " AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [400 400 400] \"bool twosided\" true "
    "Translate -2 2 0 Rotate 90 1 0 0 Rotate 45 0 1 0 Shape \"disk\" \"float radius\" 0.05 AttributeEnd" +
    kFloor + Ball("\"dielectric\" \"spectrum eta\" \"glass-F11\"");

Outcome Compare(const std::string& world, int depth, const Method& a, const Method& b, double scale,
                uint64_t seed) {
    const auto textOf = [&](const Method& method) {
        return [&world, &method, depth](uint64_t s) { return Text(world, method, depth, s); };
    };
    return test::CompareRenders({a.name, textOf(a)}, {b.name, textOf(b)}, scale, seed);
}
void ExpectAgreement(const std::string& world, int depth, const Method& a, const Method& b) {
    EXPECT_TRUE(
        Passes(FullTestName(), kAlpha, [&](uint64_t seed) { return Compare(world, depth, a, b, 1, seed); }));
}

// Power: the standard error of the whole image is 0.7 %, of caustics 1.2 % and of dispersed ones 1.5 %;
// blocks have about four times as much. The control is off by 10 %.
TEST(Mlt, MakesTheImageOfPathsThatAreIndependent) {
    ExpectAgreement(kGlossyRoom, 4, {"path", 32}, Mlt(16, 8000));
}
TEST(Mlt, MakesCausticsOfPathsFromTheLights) { ExpectAgreement(kCaustic, 4, {"bdpt", 16}, Mlt(32, 8000)); }
TEST(Mlt, MakesTheColoursOfDispersion) { ExpectAgreement(kDispersion, 4, {"bdpt", 16}, Mlt(32, 8000)); }
TEST(Mlt, NegativeControlTenPerCentAreFound) {
    EXPECT_LT(Compare(kGlossyRoom, 4, {"path", 32}, Mlt(16, 8000), 1.1, SeedOf(FullTestName())).pValue,
              kAlpha);
}

/// Of one long render.
struct Errors {
    double mean = 0, typicalPixel = 0, worstPixel = 0;  ///< relative
};
Errors ErrorsOf(const Image& image, const Image& reference) {
    double sum = 0, all = 0, squares = 0, worst = 0;
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            const double a = test::LuminanceAt(image, {x, y}), b = test::LuminanceAt(reference, {x, y});
            sum += a;
            all += b;
            const double error = std::abs(a - b) / std::max(b, 0.1);
            squares += Sqr(error);
            worst = std::max(worst, error);
        }
    return {std::abs(sum / all - 1), std::sqrt(squares / (kSize * kSize)), worst};
}
// Of six seeds, the standard deviation of the mean was 0.35 %.
TEST(Mlt, ConvergesInTheMean) {
    const int samples = test::Scaled(1024);
    const auto reference = RenderText(Text(kOpenAir, {"path", samples}, 3, 1));
    const auto image = RenderText(Text(kOpenAir, Mlt(samples, 40 * samples, 500), 3, 2));
    EXPECT_LT(ErrorsOf(*image, *reference).mean, samples < 1024 ? 0.05 : 0.01);
}
// Of six seeds with half of the mutations, the worst pixel had a standard deviation of 19 %.
TEST(Mlt, ConvergesPixelByPixel) {
    const int samples = test::Scaled(1024);
    const auto reference = RenderText(Text(kMatteRoom, {"path", samples}, 3, 1));
    const auto image = RenderText(Text(kMatteRoom, Mlt(2 * samples, 40 * samples, 500), 3, 2));
    const Errors errors = ErrorsOf(*image, *reference);
    EXPECT_LT(errors.typicalPixel, samples < 1024 ? 0.5 : 0.1);
    EXPECT_LT(errors.worstPixel, samples < 1024 ? 2 : 0.4);
}

TEST(Mlt, DoesNotDependOnThreads) {
    const auto render = [&](int threads) {
        const ThreadLimit limit(threads);
        return RenderText(
            Text(kGlassRoom + Ball("\"coateddiffuse\" \"float roughness\" 0.2"), Mlt(16), 4, 3));
    };
    const auto one = render(1);
    for (const int threads : {2, 3}) EXPECT_EQ(one->Pixels(), render(threads)->Pixels()) << threads;
}
TEST(Mlt, DependsOnTheSeed) {
    const auto render = [](int seed) { return RenderText(Text(kMatteRoom, Mlt(2), 2, uint64_t(seed))); };
    EXPECT_EQ(render(1)->Pixels(), render(1)->Pixels());
    EXPECT_NE(render(1)->Pixels(), render(2)->Pixels());
}

// A part of the image has the light of that part, up to its edges: splats of a wide filter come from beyond.
TEST(Mlt, RendersCropWindows) {
    EXPECT_TRUE(Passes(FullTestName(), kAlpha, [](uint64_t seed) {
        RunningMean whole, part;
        for (int k = 0; k < 12; ++k) {
            const std::string text = Text(kMatteRoom, Mlt(32), 3, Hash(seed, k));
            const std::string crop =
                Text(kMatteRoom, Mlt(32), 3, Hash(seed, k, 1), " \"integer pixelbounds\" [3 7 8 14]");
            const auto a = RenderText(text), b = RenderText(crop);
            double sumA = 0, sumB = 0;
            for (int y = 0; y < 6; ++y)
                for (int x = 0; x < 4; ++x) {
                    sumA += test::LuminanceAt(*a, {x + 3, y + 8});
                    sumB += test::LuminanceAt(*b, {x, y});
                }
            whole.Add(sumA / 24);
            part.Add(sumB / 24);
        }
        const double error = std::hypot(whole.StandardError(), part.StandardError());
        const double z = (whole.Mean() - part.Mean()) / error;
        // Power: the standard error is 1 %.
        return Outcome{test::NormalTwoSided(z / 1.4), std::to_string(z)};
    }));
}

// What a camera ray meets is as with other integrators.
TEST(Mlt, FillsAuxiliaryOutputs) {
    const auto alphaOf = [](const Method& method) {
        const RenderSetup setup = test::BuildText(Text(kMatteRoom, method, 2, 5));
        const auto aovs = MakeAovBuffer({"alpha"}, 0, setup);
        RenderOptions options;
        options.aovs = aovs.get();
        test::RenderAll(setup, options);
        return aovs->AppendTo(*setup.film->Develop());
    };
    const auto a = alphaOf(Mlt(8)), b = alphaOf({"lightpath", 8});
    const int channel = a->FindChannel("A");
    ASSERT_GE(channel, 0);
    double covered = 0;
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            EXPECT_EQ(a->Get({x, y}, channel), b->Get({x, y}, channel));
            covered += double(a->Get({x, y}, channel));
        }
    EXPECT_GT(covered, 20);
}

double Brightest(const Image& image) {
    double brightest = 0;
    for (const float value : image.Pixels()) brightest = std::max(brightest, double(std::abs(value)));
    return brightest;
}
TEST(Mlt, IsBlackWhereNoLightReachesTheCameraAndSaysSo) {
    const std::string sealed =
        " Material \"diffuse\" \"rgb reflectance\" [0 0 0] AttributeBegin Translate 0.5 2.2 -0.5 Shape "
        "\"sphere\" "
        "\"float radius\" 0.4 AttributeEnd";
    const std::string dark = kFloor + Ball("\"diffuse\"");
    for (const std::string& world : {kLamp + sealed + dark, dark}) {
        const RenderSetup setup = test::BuildText(Text(world, Mlt(4, 100, 7), 3, 1));
        test::WarningList warnings;
        RenderOptions options;
        options.endSample = setup.samplesPerPixel;
        const RenderStats stats =
            Render(*setup.scene, *setup.integrator, *setup.sampler, *setup.film, options, warnings);
        EXPECT_EQ(stats.samples, 4 * kSize * kSize);
        EXPECT_FALSE(stats.interrupted);
        EXPECT_EQ(Brightest(*setup.film->Develop()), 0);
        EXPECT_NE(warnings.text.find("none of the 400 paths"), std::string::npos) << warnings.text;
    }
}

/// Stops after so many calls.
class Impatient final : public Observer {
  public:
    explicit Impatient(int calls) : calls_(calls) {}
    bool ShouldStop() override { return --calls_ < 0; }

  private:
    std::atomic<int> calls_;
};
// Wherever it stops, the image is one of as many samples as there were mutations.
TEST(Mlt, CanBeStopped) {
    for (const int calls : {0, 5, 100, 250}) {
        const RenderSetup setup = test::BuildText(Text(kMatteRoom, Mlt(512, 2000, 50), 2, 1));
        Impatient observer(calls);
        RenderOptions options;
        options.endSample = setup.samplesPerPixel;
        const RenderStats stats =
            Render(*setup.scene, *setup.integrator, *setup.sampler, *setup.film, options, observer);
        EXPECT_TRUE(stats.interrupted);
        EXPECT_LT(stats.samplesPerPixel, 512);
        EXPECT_EQ(stats.samples > 0, calls >= 100) << calls;
        const double brightness = test::PixelLuminance(*setup.film->Develop()).Mean();
        if (stats.samples > 1000) {
            EXPECT_NEAR(brightness, 0.2, 0.2);
        }
    }
}

// Mutations are the samples, whatever the sampler.
TEST(Mlt, TakesItsMutationsForSamples) {
    const std::string before =
        "Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 8 Sampler "
        "\"stratified\" \"integer xsamples\" 3 Integrator \"mlt\" ";
    const std::string after = " WorldBegin LightSource \"infinite\" Shape \"sphere\"";
    EXPECT_EQ(test::BuildText(before + after).samplesPerPixel, 100);
    EXPECT_EQ(test::BuildText(before + "\"integer mutationsperpixel\" 7" + after).samplesPerPixel, 7);
    BuildOptions options;
    options.samplesPerPixel = 5;
    EXPECT_EQ(
        BuildScene(ParseText(before + after, "scene.pbrt", "", nullptr), options, nullptr).samplesPerPixel,
        5);
    EXPECT_NE(test::BuildErrorsOf("Sampler \"stratifeid\" Integrator \"mlt\" WorldBegin").find("stratified"),
              std::string::npos);
}

TEST(Mlt, RefusesParametersOutOfRange) {
    const auto errors = [](const std::string& parameters) {
        return test::BuildErrorsOf("Integrator \"mlt\" " + parameters + " WorldBegin Shape \"sphere\"");
    };
    EXPECT_EQ(errors("\"float sigma\" 0.1 \"integer chains\" 3"), "");
    for (const std::string wrong :
         {"\"integer maxdepth\" -1", "\"integer maxdepth\" 1001", "\"integer bootstrapsamples\" 0",
          "\"integer chains\" 0", "\"integer chains\" 2000000", "\"integer mutationsperpixel\" 0",
          "\"float largestepprobability\" 1.5", "\"float largestepprobability\" -0.1", "\"float sigma\" -1",
          "\"float sigma\" 2", "\"integer chain\" 3"}) {
        const size_t name = wrong.find(' ') + 1;
        EXPECT_NE(errors(wrong).find(wrong.substr(name, wrong.find('"', name) - name)), std::string::npos)
            << wrong << ": " << errors(wrong);
    }
    EXPECT_NE(errors("\"integer bootstrapsamples\" 100000000").find("at most"), std::string::npos);
    EXPECT_NE(test::BuildErrorsOf("Camera \"orthographic\" Integrator \"mlt\" WorldBegin Shape \"sphere\"")
                  .find("perspective camera only"),
              std::string::npos);
}

}  // namespace
}  // namespace lacquer::mlt_test
