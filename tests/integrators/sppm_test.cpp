// Photon mapping finds the image that paths find, with every light, through glass and mirrors, in colours,
// and with the same bits however it is divided.
#include <gtest/gtest.h>

#include "integrators/render_fixtures.h"
#include "pbrt/core/parallel.h"
#include "pbrt/integrators/photon_pass.h"

namespace lacquer::sppm_test {
namespace {

using test::FullTestName;
using test::Outcome;
using test::Passes;
using test::RenderText;
using test::RunningMean;
using test::SeedOf;

constexpr double kAlpha = 1e-5;
constexpr int kSize = 16;

struct SceneText {
    std::string name;
    std::string world;
    int depth = 3;
    std::string before = {};  ///< the camera: the medium around it
};

const std::string kLamp =
    "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [8 8 8] Translate 0.5 2 -0.5 Rotate 80 1 0 0 Shape "
    "\"disk\" \"float radius\" 0.5 AttributeEnd ";
const std::string kBall =
    "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [8 8 8] \"bool twosided\" true Translate 0.5 1.6 "
    "-0.5 Shape \"sphere\" \"float radius\" 0.4 AttributeEnd ";
const std::string kSky = "LightSource \"infinite\" \"rgb L\" [.5 .5 .5] ";
const std::string kPoint = "LightSource \"point\" \"point3 from\" [0 2 -1] \"float scale\" 6 ";
const std::string kMatte = "Material \"diffuse\" \"rgb reflectance\" [.7 .7 .7] ";
const std::string kFloor =
    " AttributeBegin Translate 0 -1 0 Rotate -90 1 0 0 Shape \"disk\" \"float radius\" 6 AttributeEnd ";
const std::string kWall =
    " AttributeBegin Translate 0 0 1.8 Rotate 180 1 0 0 Shape \"disk\" \"float radius\" 6 AttributeEnd ";

/// A floor and a wall, a sphere, and two triangles whose shading normals are far from their own.
std::string Room(const std::string& light, const std::string& material) {
    return light + kMatte + kFloor + kWall + " AttributeBegin " + material +
           " Translate -0.7 -0.2 0 Shape \"sphere\" \"float radius\" 0.7 AttributeEnd AttributeBegin " +
           material +
           " Translate 0.8 -0.3 0.2 Rotate 20 0 1 0 Shape \"trianglemesh\" \"point3 P\" [-.6 -.6 0 .6 -.6 0 "
           ".6 .6 .3 -.6 .6 .3] \"normal N\" [-.3 -.3 -1 .3 -.3 -1 .3 .3 -1 -.3 .3 -1] \"integer indices\" "
           "[0 "
           "1 2 0 2 3] AttributeEnd ";
}
/// A ball of glass above a floor, and what shines through it.
std::string Caustic(const std::string& light, const std::string& glass, const std::string& floor) {
    return light + floor + kFloor + " AttributeBegin " + glass +
           " Translate 0 0.2 0 Shape \"sphere\" \"float radius\" 0.6 AttributeEnd ";
}

/// A floor and a wall that get their light through a pane: what enters it never leaves it.
std::string UnderPane(const std::string& light, const std::string& material) {
    return light + kMatte + kFloor + kWall + " AttributeBegin " + material +
           " Translate 0 1 0 Rotate -90 1 0 0 Shape \"disk\" \"float radius\" 4 AttributeEnd ";
}
/// A wall, and a floor whose shading normals lean far to the side.
std::string LeaningFloor(const std::string& light) {
    return light + kMatte + kWall +
           " Shape \"trianglemesh\" \"point3 P\" [-6 -1 -6 6 -1 -6 6 -1 6 -6 -1 6] \"normal N\" [.7 .7 0 .7 "
           ".7 0 .7 .7 0 .7 .7 0] \"integer indices\" [0 1 2 0 2 3] ";
}

std::string FullText(const SceneText& scene, const std::string& integrator, int samples, uint64_t seed) {
    const std::string number = std::to_string(seed % 100000000);
    const bool isSppm = integrator == "sppm";
    return scene.before +
           "LookAt 0 0.5 -4  0 0 0  0 1 0 Camera \"perspective\" \"float fov\" 45 Film \"rgb\" \"integer "
           "xresolution\" " +
           std::to_string(kSize) + " \"integer yresolution\" " + std::to_string(kSize) +
           " Sampler \"independent\" \"integer pixelsamples\" " + std::to_string(samples) +
           " \"integer seed\" " + number + " Integrator \"" + integrator + "\" \"integer maxdepth\" " +
           std::to_string(scene.depth) +
           (isSppm ? " \"float radius\" 0.12 \"integer photonsperiteration\" 4000 \"integer seed\" " + number
                   : "") +
           " WorldBegin " + scene.world;
}

/// Means of the blocks of `count` renderings in one channel, and of the whole image.
constexpr int kLuminance = 3;  ///< in the place of a channel
constexpr int kBlocks = 4;
using BlockMeans = std::array<RunningMean, kBlocks * kBlocks + 1>;
BlockMeans MeansOf(const SceneText& scene, const std::string& integrator, int channel, int samples, int count,
                   uint64_t seed) {
    BlockMeans means;
    for (int k = 0; k < count; ++k) {
        const auto image = RenderText(FullText(scene, integrator, samples, Hash(seed, k)));
        std::array<double, kBlocks * kBlocks + 1> sums{};
        for (int y = 0; y < kSize; ++y)
            for (int x = 0; x < kSize; ++x) {
                const double value = (channel == kLuminance ? test::LuminanceAt(*image, {x, y})
                                                            : double(image->Get({x, y}, channel))) /
                                     (kSize * kSize);
                sums[size_t(y * kBlocks / kSize * kBlocks + x * kBlocks / kSize)] +=
                    value * kBlocks * kBlocks;
                sums.back() += value;
            }
        for (size_t i = 0; i < sums.size(); ++i) means[i].Add(sums[i]);
    }
    return means;
}

/// What blurring by the radius may change of a block, and of the image.
constexpr double kBlockBlur = 0.03, kImageBlur = 0.01;

/// The whole image and the worst of its blocks, `scale` times one against the other.
Outcome Compare(const SceneText& scene, const std::string& other, double scale, uint64_t seed,
                int channel = kLuminance, int samplesOfOther = 16) {
    constexpr int kCount = 12, kSamples = 4;
    const BlockMeans a = MeansOf(scene, other, channel, samplesOfOther, kCount, Hash(seed, 1));
    const BlockMeans b = MeansOf(scene, "sppm", channel, kSamples, kCount, Hash(seed, 2));
    std::vector<Outcome> outcomes;
    for (size_t i = 0; i < a.size(); ++i) {
        const double variance = a[i].Variance() / kCount + b[i].Variance() / kCount;
        const double blur = (i + 1 < a.size() ? kBlockBlur : kImageBlur) * std::abs(a[i].Mean());
        const double difference = scale * b[i].Mean() - a[i].Mean();
        // Student's t, by the normal deviate of the same tail (Wallace's approximation).
        constexpr double kDegrees = 22;
        const double t = std::max(std::abs(difference) - blur, 0.) / std::sqrt(std::max(variance, 1e-16));
        const double z =
            std::sqrt(kDegrees * std::log1p(t * t / kDegrees)) * (8 * kDegrees + 1) / (8 * kDegrees + 3);
        outcomes.push_back({test::NormalTwoSided(z),
                            scene.name + ", part " + std::to_string(i) + ": " + std::to_string(difference) +
                                " of " + std::to_string(a[i].Mean()) + ", t " + std::to_string(t)});
    }
    return test::WorstOf(outcomes);
}

std::string Coated(const std::string& roughness) {
    return "Material \"coateddiffuse\" \"float roughness\" " + roughness + " ";
}
/// A dark floor under a smooth coat of high index: it mirrors the wall.
std::string CoatedWall(const std::string& light, const std::string& wall) {
    return light + wall + kWall + Coated("0") +
           "\"float eta\" 2.4 \"rgb reflectance\" [.05 .05 .05] \"float thickness\" 1e-4 " + kFloor;
}
std::string Spot(const std::string& to, int coneAngle = 12) {
    return "LightSource \"spot\" \"point3 from\" [0 2 -1] \"point3 to\" [" + to +
           "] \"float scale\" 9 \"float coneangle\" " + std::to_string(coneAngle) + " ";
}
std::vector<SceneText> Scenes() {
    const std::string glass = "Material \"dielectric\" ", mirror = "Material \"conductor\" ";
    return {{"Disk", Room(kLamp, kMatte)},
            {"Ball", Room(kBall, "Material \"conductor\" \"float roughness\" 0.3 ")},
            {"Point", Room(kPoint, kMatte)},
            {"Spot", Room(Spot("0 -1 0", 30), kMatte)},
            {"Distant", Room("LightSource \"distant\" \"point3 from\" [1 2 -3] \"float scale\" 3 ", kMatte)},
            {"Sky", Room(kSky, "Material \"conductor\" \"float roughness\" 0.3 ")},
            {"Two", Room(kLamp + kPoint, "Material \"dielectric\" \"float roughness\" 0.3 "), 6},
            // What is seen along specular paths may be deeper than maxdepth: here little of the light is.
            {"SmoothGlass", Room(kBall, glass), 12},
            {"Mirror", Room(kBall, mirror), 8},
            {"Translucent", Room(kBall, "Material \"diffusetransmission\" "), 4},
            {"Interface", Room(kBall, "Material \"interface\" ")},
            {"SmoothPane", UnderPane(kLamp, glass)},
            {"RoughPane", UnderPane(kLamp, "Material \"dielectric\" \"float roughness\" 0.3 ")},
            {"SkyBehindInterface", UnderPane(kSky, "Material \"interface\" ")},
            {"LeaningFloor", LeaningFloor(Spot("0 0 1.8")), 2},
            {"UnderLeaningFloor", LeaningFloor(Spot("0 -1 0.3")), 2},
            {"CoatedSmooth", Room(kLamp + kSky, Coated("0")), 8},
            {"CoatedWall", CoatedWall(kLamp, kMatte), 8},
            {"CoatedRough", Room(kLamp + kSky, Coated("0.3")), 3}};
}

// Power: the whole image has a standard error of about 0.5 %, blocks of up to 3 %; see the control below.
// These mistakes were made on purpose, and found here and in the tests below. Photons that also have the
// light that comes straight from the lights: half of the scenes. A cosine more: nearly all. No cosines for
// the plane of the shading normal where photons arrive: LeaningFloor; none where they scatter:
// UnderLeaningFloor. Radiance's factor of refraction: both panes. Survivors of the roulette that do not stand
// for the others: half of them. Emission that is found by chance counted fully: half of them. An interface
// that ends the last ray: SkyBehindInterface. No reflection in a coat over a diffuse base: CoatedWall. No
// photons for the light of a point on glossy surfaces: FindsTheCausticOnAGlossySurface. Photons of one
// wavelength that count at all, or at another one: PhotonsBehindAPrism...; the same of paths from the camera:
// KeepsTheColours...
class EveryScene : public testing::TestWithParam<size_t> {};
TEST_P(EveryScene, MakesTheImageOfThePathTracer) {
    const SceneText scene = Scenes()[GetParam()];
    EXPECT_TRUE(Passes(FullTestName() + scene.name, kAlpha,
                       [&](uint64_t seed) { return Compare(scene, "volpath", 1, seed); }));
}
INSTANTIATE_TEST_SUITE_P(Sppm, EveryScene, testing::Range(size_t(0), Scenes().size()),
                         [](const auto& test) { return Scenes()[test.param].name; });

// In red and in blue. Power: as above.
TEST(Sppm, GoesThroughMedia) {
    const auto medium = [](const std::string& parameters) {
        return "MakeNamedMedium \"m\" \"string type\" \"homogeneous\" " + parameters + " ";
    };
    const std::string coloured = medium("\"rgb sigma_a\" [0.2 0.1 0.4] \"rgb sigma_s\" [0.8 1.6 0.3]");
    const std::string glowing =
        medium("\"rgb sigma_a\" [1 0.5 0.3] \"rgb sigma_s\" [0.8 1.6 0.3] \"rgb Le\" [2 2 1]");
    const std::string thin = medium("\"rgb sigma_a\" [0.03 0.01 0.05] \"rgb sigma_s\" [0.1 0.2 0.03]");
    const std::string ball =
        "MediumInterface \"m\" \"\" Material \"interface\" Shape \"sphere\" \"float radius\" 0.9 ";
    const std::string around = "MediumInterface \"\" \"m\" ";
    const std::vector<SceneText> scenes = {
        {"BallUnderALamp", kLamp + kMatte + kFloor + kWall + coloured + ball, 12},
        {"BallUnderASky", kSky + kMatte + kFloor + kWall + coloured + ball, 12},
        {"BallByAPoint", kPoint + kMatte + kFloor + kWall + coloured + ball, 12},
        {"Fog", kLamp + kMatte + kFloor + kWall, 12, thin + around},
        {"FogAndTwoBalls", kBall + kLamp + kMatte + kFloor + kWall, 12, thin + around},
        // Between bright planes, so that half of the light has been on both.
        {"GlowingBall",
         "Material \"diffuse\" \"rgb reflectance\" [.9 .9 .9] " + kFloor + kWall +
             "AttributeBegin Translate 0 1.2 0 Rotate 90 1 0 0 Shape \"disk\" \"float radius\" 3 "
             "AttributeEnd " +
             glowing + ball,
         12},
        {"GlowingBallAndLamp", kLamp + Room("", kMatte) + glowing + ball, 12},
        {"FogAndGlass", Room(kBall, "Material \"dielectric\" "), 14, thin + around},
        {"FogAndFlint", Room(kBall, "Material \"dielectric\" \"spectrum eta\" \"glass-F11\" "), 14,
         thin + around}};
    for (const SceneText& scene : scenes)
        for (const int channel : {0, 2})
            EXPECT_TRUE(Passes(FullTestName() + scene.name + std::to_string(channel), kAlpha,
                               [&](uint64_t seed) { return Compare(scene, "volpath", 1, seed, channel); }));
}

TEST(Sppm, NegativeControlAFewPerCentAreFound) {
    const SceneText scene{"Disk", Room(kLamp, kMatte)};
    EXPECT_LT(Compare(scene, "volpath", 1.06, SeedOf(FullTestName())).pValue, kAlpha);
    EXPECT_LT(Compare(scene, "volpath", 0.94, SeedOf(FullTestName())).pValue, kAlpha);
}

const std::string kGlass = "Material \"dielectric\" ";
const std::string kFlint = "Material \"dielectric\" \"spectrum eta\" \"glass-F11\" ";

// Light that is focused by a ball of glass: bidirectional paths find it where the camera sees the floor
// itself.
TEST(Sppm, FindsTheCausticOfBidirectionalPaths) {
    const std::string lamp =
        "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [90 90 90] Translate 0.6 3 0 Rotate 90 1 0 0 "
        "Shape \"disk\" \"float radius\" 0.2 AttributeEnd ";
    const SceneText area{"area", Caustic(lamp, kGlass, kMatte), 12};
    EXPECT_TRUE(Passes(FullTestName(), kAlpha,
                       [&](uint64_t seed) { return Compare(area, "bdpt", 1, seed, kLuminance, 64); }));
    const SceneText point{"point", Caustic(kPoint, kGlass, kMatte), 12};
    EXPECT_TRUE(Passes(FullTestName() + "point", kAlpha,
                       [&](uint64_t seed) { return Compare(point, "bdpt", 1, seed, kLuminance, 64); }));
}

// Glossy surfaces leave what they can to the path; the light of a point that glass focuses on them is found
// by photons alone.
TEST(Sppm, FindsTheCausticOnAGlossySurface) {
    const SceneText scene{"glossy",
                          Caustic(kPoint, kGlass, "Material \"conductor\" \"float roughness\" 0.5 "), 12};
    EXPECT_TRUE(Passes(FullTestName(), kAlpha,
                       [&](uint64_t seed) { return Compare(scene, "bdpt", 1, seed, kLuminance, 64); }));
}

// Colours of a caustic through glass of strong dispersion, each channel by itself.
TEST(Sppm, DispersesLikeBidirectionalPaths) {
    const SceneText scene{"flint", Caustic(kPoint, kFlint, kMatte), 12};
    for (int channel = 0; channel < 3; ++channel)
        EXPECT_TRUE(Passes(FullTestName() + std::to_string(channel), kAlpha,
                           [&](uint64_t seed) { return Compare(scene, "bdpt", 1, seed, channel, 64); }));
}

// A red room through flint: what is seen by one wavelength counts as that wavelength alone.
TEST(Sppm, KeepsTheColoursOfWhatIsSeenThroughFlint) {
    const SceneText scene{"red",
                          kBall + "Material \"diffuse\" \"rgb reflectance\" [.7 .1 .05] " + kFloor + kWall +
                              "AttributeBegin " + kFlint +
                              "Translate 0 0 -1.5 Shape \"sphere\" \"float radius\" 0.9 AttributeEnd ",
                          12};
    for (int channel = 0; channel < 3; ++channel)
        EXPECT_TRUE(Passes(FullTestName() + std::to_string(channel), kAlpha,
                           [&](uint64_t seed) { return Compare(scene, "volpath", 1, seed, channel); }));
}

/// Index of what kFlint is, by its name.
float FlintIndex(float lambda) {
    static const std::unique_ptr<Spectrum> index = NamedSpectrum("glass-F11");
    return index->Evaluate(lambda);
}
/// The photons of one iteration of a scene.
std::unique_ptr<const SharedSample> PhotonsOf(const RenderSetup& setup, ThreadState& state, int iteration) {
    const ThreadLimit one(1);
    return setup.integrator->ShareSample({.film = *setup.film,
                                          .index = iteration,
                                          .seed = 1,
                                          .state = [&]() -> ThreadState& { return state; },
                                          .isStopped = [] { return false; }});
}

// Each photon behind a prism is where the refraction of its wavelength puts it, and all eight occur.
TEST(Sppm, PhotonsBehindAPrismKnowTheirWavelengths) {
    // Light comes straight down on the level side of a prism, and leaves it by a side of 30 degrees.
    const auto setup = test::BuildText(
        "Film \"rgb\" Integrator \"sppm\" \"integer maxdepth\" 3 \"integer photonsperiteration\" 4000 "
        "WorldBegin LightSource \"distant\" "
        "\"point3 from\" [0 0 1] \"point3 to\" [0 0 0] Material \"diffuse\" Shape \"disk\" \"float radius\" "
        "6 " +
        kFlint +
        "AttributeBegin Translate 0 0 10 Shape \"disk\" \"float radius\" 1 AttributeEnd AttributeBegin "
        "Translate 0 0 "
        "9 Rotate 30 0 1 0 ReverseOrientation Shape \"disk\" \"float radius\" 2 AttributeEnd");
    ThreadState state;
    std::array<int, kNumWavelengths> counts{};
    for (int iteration = 0; iteration < 4; ++iteration) {
        const auto shared = PhotonsOf(setup, state, iteration);
        const auto& pass = static_cast<const PhotonPass&>(*shared);
        for (const Photon& photon : pass.Map().Photons()) {
            // What went past the prism and was scattered comes from anywhere.
            if (std::abs(photon.wi.y) > 1e-4f) continue;
            int lane = 0, numLanes = 0;
            for (int i = 0; i < kNumWavelengths; ++i)
                if (photon.flux[i] > 0) lane = i, ++numLanes;
            ASSERT_EQ(numLanes, 1);
            ++counts[size_t(lane)];
            const double eta = double(FlintIndex(pass.Wavelengths()[lane]));
            const double deviation = std::asin(eta * 0.5) - double(Pi) / 6;
            EXPECT_NEAR(std::acos(double(photon.wi.z)), deviation, 1e-3);
        }
    }
    for (const int count : counts) EXPECT_GT(count, 5);
}

/// Reflectance of a pane of index 1.5, with all reflections inside of it.
double PaneReflectance(double cosTheta) {
    const double eta = 1.5, cosInside = std::sqrt(1 - (1 - cosTheta * cosTheta) / (eta * eta));
    const double s = (cosTheta - eta * cosInside) / (cosTheta + eta * cosInside);
    const double p = (eta * cosTheta - cosInside) / (eta * cosTheta + cosInside);
    const double once = (s * s + p * p) / 2;
    return once + (1 - once) * (1 - once) * once / (1 - once * once);
}

/// A beam falls onto a floor at an angle to the normal, through a pane that all of it has to cross: radiance
/// is T cos(angle) rho / pi. @param scale  by which photons count wrongly
Outcome LightThroughAPane(float angleDeg, double scale, uint64_t seed) {
    const double angle = double(Radians(angleDeg)), c = std::cos(angle), s = std::sin(angle);
    RunningMean mean;
    for (int k = 0; k < 12; ++k) {
        const std::string number = std::to_string(Hash(seed, k) % 100000000);
        const auto image = RenderText(
            "LookAt 0 0 .2 0 0 0 0 1 0 Camera \"orthographic\" \"float screenwindow\" [-.5 .5 -.5 .5] Film "
            "\"rgb\" \"integer xresolution\" 4 \"integer yresolution\" 4 Sampler \"independent\" \"integer "
            "pixelsamples\" 8 \"integer seed\" " +
            number +
            " Integrator \"sppm\" \"integer maxdepth\" 2 \"float radius\" 0.2 \"integer "
            "photonsperiteration\" "
            "20000 \"integer seed\" " +
            number + " WorldBegin LightSource \"distant\" \"point3 from\" [" + std::to_string(s) + " 0 " +
            std::to_string(c) +
            "] \"point3 to\" [0 0 0] Material \"diffuse\" \"rgb reflectance\" [.8 .8 .8] Shape \"disk\" "
            "\"float radius\" 1 Material \"thindielectric\" \"float eta\" 1.5 Translate 0 0 .3 Shape "
            "\"disk\" "
            "\"float radius\" 4");
        mean.Add(scale * test::PixelLuminance(*image).Mean());
    }
    const double expected = (1 - PaneReflectance(c)) * c * 0.8 / double(Pi);
    // Normal deviates for twelve numbers: three times as wide tails at 1e-5.
    return test::ZTest(mean, expected, 0.002 * expected, "angle " + std::to_string(angleDeg));
}

// Irradiance falls as the cosine while the flux through the floor is what photons carry: no cosine may be
// left out, or be there twice. The standard error is 0.3 % at 0 degrees and 2 % at 84.
TEST(Sppm, LightFallsOffByTheCosine) {
    for (const float angle : {0.f, 60.f, 84.f})
        EXPECT_TRUE(Passes(FullTestName() + std::to_string(angle), kAlpha,
                           [&](uint64_t seed) { return LightThroughAPane(angle, 1, seed); }));
    EXPECT_LT(LightThroughAPane(60, 1.05, SeedOf(FullTestName())).pValue, kAlpha);
}

// The same bits, whatever the threads, parts and crops.
std::string ManyThings(const std::string& film = "") {
    std::string text = FullText({"",
                                 Room(kBall + kPoint, "Material \"conductor\" \"float roughness\" 0.3 ") +
                                     kFlint + "Translate 0.6 0.6 -0.5 Shape \"sphere\" \"float radius\" 0.4",
                                 6},
                                "sppm", 6, 7);
    text.insert(text.find("Sampler"), film + " ");
    return text;
}
TEST(Sppm, DoesNotDependOnThreads) {
    const auto render = [&](int threads) {
        const ThreadLimit limit(threads);
        return RenderText(ManyThings());
    };
    const auto one = render(1);
    for (const int threads : {2, 3}) EXPECT_EQ(one->Pixels(), render(threads)->Pixels());
}
TEST(Sppm, SeedsTellPhotonsApart) {
    const std::string text = ManyThings();
    std::string other = text;
    const size_t at = text.rfind("\"integer seed\" 7", text.find("WorldBegin"));
    other.replace(at, 16, "\"integer seed\" 8");
    EXPECT_NE(RenderText(text)->Pixels(), RenderText(other)->Pixels());
}

/// Samples [first, end) of a film that may have some.
void RenderPart(const RenderSetup& setup, int first, int end, bool resumes = false) {
    RenderOptions options;
    options.firstSample = first;
    options.endSample = end;
    options.resumes = resumes;
    test::RenderAll(setup, options);
}
TEST(Sppm, PartsOfTheIterationsMakeTheWhole) {
    const auto whole = RenderText(ManyThings());
    // One after the other in one film, and as a render that goes on.
    const RenderSetup parts = test::BuildText(ManyThings()), resumed = test::BuildText(ManyThings());
    RenderPart(parts, 4, 6);
    RenderPart(parts, 0, 4);
    EXPECT_EQ(parts.film->Develop()->Pixels(), whole->Pixels());
    RenderPart(resumed, 0, 2);
    RenderPart(resumed, 0, 6, true);
    EXPECT_EQ(resumed.film->Develop()->Pixels(), whole->Pixels());
}
TEST(Sppm, ACropIsAPartOfTheImage) {
    const auto whole = RenderText(ManyThings());
    const auto crop = RenderText(ManyThings("\"integer pixelbounds\" [4 12 6 10]"));
    ASSERT_EQ(crop->Resolution(), Int2(8, 4));
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 8; ++x)
            for (int c = 0; c < 3; ++c) ASSERT_EQ(crop->Get({x, y}, c), whole->Get({x + 4, y + 6}, c));
}

// Photons of one wavelength alone stand for all: the mean over paths is the spectrum.
TEST(Sppm, OneWavelengthStandsForAll) {
    const SampledSpectrum s(SampledSpectrum::Lanes{3, 1, 4, 1, 5, 9, 2, 6});
    EXPECT_EQ(OnlyFirst(s)[0], 3 * kNumWavelengths);
    for (int i = 1; i < kNumWavelengths; ++i) EXPECT_EQ(OnlyFirst(s)[i], 0);
}

// gamma(n + alpha) / (gamma(n + 1) gamma(1 + alpha)), at both sides of where the product becomes a power.
TEST(Sppm, RadiusShrinksByTheRuleOfKnausAndZwicker) {
    EXPECT_EQ(RadiusScale(0), 1);
    for (const int n : {2, 3, 17, 4095, 4096, 4097, 5000, 100000, 10000000}) {
        const double expected = std::exp(
            (std::lgamma(n + kRadiusAlpha) - std::lgamma(n + 1.) - std::lgamma(1 + kRadiusAlpha)) / 2);
        EXPECT_NEAR(RadiusScale(n - 1), expected, 1e-6 * expected) << n;
    }
}

TEST(Sppm, LeavesLightFromFarInAMediumWithoutWallsToVolPath) {
    test::WarningList warnings;
    const auto setup = test::BuildText(
        "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" MediumInterface \"\" \"fog\" Camera "
        "\"perspective\" Integrator \"sppm\" \"integer photonsperiteration\" 9 \"float radius\" 2 \"integer "
        "seed\" 3 WorldBegin LightSource \"infinite\"",
        &warnings);
    EXPECT_NE(warnings.text.find(
                  "integrator \"sppm\" begins no paths at distant and infinite lights in a medium without "
                  "walls; \"volpath\" renders the scene instead"),
              std::string::npos)
        << warnings.text;
    EXPECT_FALSE(setup.integrator->SharesSamples());
}

TEST(Sppm, RefusesParametersOutOfRange) {
    for (const std::string wrong :
         {"\"float radius\" 0", "\"float radius\" -1", "\"integer photonsperiteration\" -2",
          "\"integer maxdepth\" -1", "\"integer photonsperiteration\" 100000000"}) {
        const std::string errors =
            test::BuildErrorsOf("Integrator \"sppm\" " + wrong + " WorldBegin LightSource \"infinite\"");
        EXPECT_NE(errors.find("must lie in ["), std::string::npos) << wrong << ": " << errors;
    }
}

TEST(Sppm, BlackWithoutLightsAndWithoutSurfaces) {
    for (const std::string world : {"", "Shape \"sphere\"", "LightSource \"point\""})
        EXPECT_EQ(test::PixelLuminance(*RenderText(FullText({"", world}, "sppm", 2, 1))).Mean(), 0) << world;
}

/// Photons in a box, and some where cells end.
std::vector<Photon> PhotonsInABox(int count, float size, uint64_t seed) {
    Rng rng(seed);
    std::vector<Photon> photons(static_cast<size_t>(count));
    for (Photon& photon : photons) {
        photon.p = size * Vec3(2 * rng.Uniform() - 1, 2 * rng.Uniform() - 1, 2 * rng.Uniform() - 1);
        photon.flux = SampledSpectrum(rng.Uniform());
    }
    return photons;
}

// Every photon within the radius once, no other one, and the same order from any blocks; also where the grid
// has an end.
TEST(PhotonMap, FindsWhatIsNear) {
    for (const float size : {1.f, 1e6f, 1e-6f, 1e12f}) {
        const std::vector<Photon> photons = PhotonsInABox(3000, size, SeedOf(FullTestName()));
        const float radius = 0.2f * size;
        const PhotonMap map({photons}, size == 1e12f ? 1 : radius);
        const PhotonMap blocks(
            {{photons.begin(), photons.begin() + 7}, {}, {photons.begin() + 7, photons.end()}}, map.Radius());
        for (size_t k = 0; k < photons.size(); k += 37) {
            const Point3 p = photons[k].p;
            double expected = 0;
            for (const Photon& photon : photons)
                if (LengthSquared(photon.p - p) < Sqr(map.Radius())) expected += double(photon.flux[0]);
            std::vector<float> found, foundOfBlocks;
            map.ForEachNear(p, [&](const Photon& photon) { found.push_back(photon.flux[0]); });
            blocks.ForEachNear(p, [&](const Photon& photon) { foundOfBlocks.push_back(photon.flux[0]); });
            double sum = 0;
            for (const float x : found) sum += double(x);
            EXPECT_NEAR(sum, expected, 1e-9 * expected);
            EXPECT_EQ(found, foundOfBlocks);
        }
    }
    PhotonMap().ForEachNear(Point3(0), [](const Photon&) { FAIL(); });
}

}  // namespace
}  // namespace lacquer::sppm_test
