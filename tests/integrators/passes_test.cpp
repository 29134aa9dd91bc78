// Passes of whole renders: their sums are the image, and they hold what their names say.
#include <gtest/gtest.h>

#include <fmt/format.h>

#include "integrators/render_fixtures.h"
#include "pbrt/film/passes.h"

namespace lacquer::passes_test {
namespace {

using test::RunningMean;

std::unique_ptr<Image> RenderPasses(const std::string& text, const std::vector<std::string>& names) {
    const RenderSetup setup = test::BuildText(text);
    EXPECT_TRUE(setup.integrator->TellsPasses());
    const std::vector<std::string>& groups = setup.scene->Parts().lightGroups;
    const PassSet passes(PassesOf(names, groups), groups);
    setup.film->KeepPasses(passes.Layers());
    RenderOptions options;
    options.passes = &passes;
    test::RenderAll(setup, options);
    return setup.film->AppendPasses(*setup.film->Develop());
}

/// Pixels where the layers (all channels after the third) do not sum to the colours. Floats are added in
/// another order: some tens of terms of a sample, each within 2^-24 of their sum, and then responses of
/// sensors, whose conversion to RGB takes differences of numbers up to five times as large: 1e-5 of the
/// pixel's largest component.
int PixelsOffTheSum(const Image& image) {
    int off = 0;
    for (int y = 0; y < image.Resolution().y; ++y)
        for (int x = 0; x < image.Resolution().x; ++x) {
            double sum[3] = {0, 0, 0}, largest = 0, worst = 0;
            for (int c = 3; c < image.NumChannels(); ++c) sum[c % 3] += double(image.Get({x, y}, c));
            for (int c = 0; c < 3; ++c) {
                const double value = double(image.Get({x, y}, c));
                largest = std::max(largest, std::abs(value));
                worst = std::max(worst, std::abs(value - sum[c]));
            }
            off += worst > 1e-5 * largest;
        }
    return off;
}

constexpr int kSide = 24;
std::string Head(const std::string& integrator, const std::string& more = "", int samples = 8) {
    return fmt::format(
        "LookAt 0 1 -5  0 0.3 0  0 1 0 Camera \"perspective\" \"float fov\" 50 Film \"rgb\" \"integer "
        "xresolution\" {0} \"integer yresolution\" {0} {1} Sampler \"independent\" \"integer pixelsamples\" "
        "{2} "
        "PixelFilter \"mitchell\" Integrator {3} ",
        kSide, more, samples, integrator);
}
/// Lights of all kinds, in groups of different names and in none.
const std::string kLights =
    "LightSource \"infinite\" \"rgb L\" [.2 .3 .5] \"string group\" \"sky\" "
    "AttributeBegin Attribute \"light\" \"string group\" \"key\" "
    "LightSource \"point\" \"point3 from\" [1 3 -2] \"rgb I\" [4 3 2] "
    "LightSource \"distant\" \"rgb L\" [.3 .2 .1] AttributeEnd "
    "LightSource \"spot\" \"point3 from\" [-2 3 -2] \"point3 to\" [0 0 0] \"rgb I\" [5 8 5] "
    "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [3 3 3] \"bool twosided\" true \"string group\" "
    "\"area\" "
    "Translate -1.5 1.5 1 Shape \"sphere\" \"float radius\" .5 AttributeEnd "
    "AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [1 2 9] Translate 1.8 .4 -.5 "
    "Shape \"disk\" \"float radius\" .3 AttributeEnd ";
/// Stacks, glass smooth and rough, a mirror, leaves, and a floor seen at grazing angles.
const std::string kThings =
    "AttributeBegin Material \"coateddiffuse\" \"float roughness\" 0.1 Shape \"sphere\" \"float radius\" .6 "
    "AttributeEnd "
    "AttributeBegin Translate 1.2 0 .5 Material \"dielectric\" Shape \"sphere\" \"float radius\" .6 "
    "AttributeEnd "
    "AttributeBegin Translate -1.2 0 0 Material \"dielectric\" \"float roughness\" 0.2 Shape \"sphere\" "
    "\"float "
    "radius\" .5 AttributeEnd "
    "AttributeBegin Translate 0 1.3 1 Material \"coatedconductor\" Shape \"sphere\" \"float radius\" .5 "
    "AttributeEnd "
    "AttributeBegin Translate 0.5 .8 -1 Material \"diffusetransmission\" Shape \"disk\" \"float radius\" .3 "
    "AttributeEnd "
    "Translate 0 -.6 0 Rotate 90 1 0 0 Material \"conductor\" \"float roughness\" .3 Shape \"disk\" \"float "
    "radius\" 60 ";

const std::vector<std::vector<std::string>> kPartitions = {
    {"emission", "direct", "indirect"},
    {"emission", "diffuse", "glossy", "transmission", "volume"},
    {"lightgroups"}};

void ExpectSums(const std::string& text, const std::string& what) {
    for (const std::vector<std::string>& names : kPartitions) {
        const auto image = RenderPasses(text, names);
        EXPECT_EQ(PixelsOffTheSum(*image), 0) << what << ": " << names[0];
    }
}

TEST(RenderedPasses, SumToTheImage) {
    for (const char* lightSampler : {"bvh", "power", "uniform", "exhaustive"})
        ExpectSums(Head(fmt::format("\"path\" \"integer maxdepth\" 8 \"string lightsampler\" \"{}\"",
                                    lightSampler)) +
                       "WorldBegin " + kLights + kThings,
                   lightSampler);
    ExpectSums(Head("\"volpath\" \"integer maxdepth\" 20 \"bool regularize\" true") + "WorldBegin " +
                   kLights + kThings,
               "regularised");
    ExpectSums(Head("\"path\"", "\"float maxcomponentvalue\" .3") + "WorldBegin " + kLights + kThings,
               "limited");
}

TEST(RenderedPasses, SumToTheImageForEveryEstimatorOfLayers) {
    for (const char* estimator : {"auto", "belcour", "bidirectional", "halfvector", "unidirectional"}) {
        const std::string material = fmt::format(
            "Material \"coateddiffuse\" \"float roughness\" 0.3 \"string estimator\" \"{}\" Shape "
            "\"sphere\" ",
            estimator);
        ExpectSums(Head("\"path\"") + "WorldBegin " + kLights + material, estimator);
    }
}

/// A portal, and an emission of no group.
TEST(RenderedPasses, SumToTheImageUnderAPortal) {
    ExpectSums(Head("\"path\"") +
                   "WorldBegin LightSource \"infinite\" \"rgb L\" [1 1 1] \"string group\" \"window\" "
                   "\"point3 portal\" "
                   "[-2 3 -2  2 3 -2  2 3 2  -2 3 2] " +
                   kLights + kThings,
               "portal");
}

const std::string kFog =
    "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" \"rgb sigma_a\" [.05 .1 .2] \"rgb sigma_s\" [.3 "
    ".2 .1] "
    "\"rgb Le\" [.4 .2 .1] \"string group\" \"glow\" "
    "MakeNamedMedium \"soot\" \"string type\" \"uniformgrid\" \"rgb sigma_a\" [.5 .5 .5] \"rgb sigma_s\" [1 "
    "1 1] "
    "\"integer nx\" 2 \"integer ny\" 2 \"integer nz\" 2 \"float density\" [0 1 2 0 1 1 3 0] \"point3 p0\" "
    "[-.6 -.6 -.6] "
    "\"point3 p1\" [.6 .6 .6] \"rgb Le\" [2 1 0] ";
const std::string kFoggy =
    "AttributeBegin MediumInterface \"soot\" \"fog\" Material \"interface\" Shape \"sphere\" \"float "
    "radius\" .6 "
    "AttributeEnd "
    "AttributeBegin Translate 1.2 0 .5 Material \"subsurface\" \"rgb mfp\" [.1 .2 .3] \"rgb reflectance\" "
    "[.8 .6 .5] "
    "Shape \"sphere\" \"float radius\" .5 AttributeEnd "
    "MediumInterface \"fog\" \"\" Material \"interface\" Shape \"sphere\" \"float radius\" 7 MediumInterface "
    "\"\" \"\" ";
std::string FogScene(const std::string& integrator, int samples = 8) {
    return kFog + "MediumInterface \"\" \"fog\" " + Head(integrator, "", samples) + "WorldBegin " + kLights +
           kFoggy + "MediumInterface \"fog\" \"fog\" " + kThings;
}

TEST(RenderedPasses, SumToTheImageInMedia) {
    ExpectSums(FogScene("\"volpath\" \"integer maxdepth\" 12"), "fog");
    ExpectSums(FogScene("\"volpath\" \"bool regularize\" true"), "regularised");
}

/// What the sums above find: an automaton that lacks one kind of event, or one source.
TEST(RenderedPasses, ThatLoseAnEventDoNotSumToTheImage) {
    const std::string text = FogScene("\"volpath\"");
    for (const std::vector<std::string>& names :
         {std::vector<std::string>{"emission", "diffuse", "glossy", "transmission"},
          {"emission", "lpe:rough=C<RG>.*", "diffuse", "transmission", "volume"},
          {"emission", "direct", "lpe:indirect2=C..+L"},
          {"lpe:all=C.*L"},
          {"lpe:long=C(D|G|V)*[LO]"}})
        EXPECT_GT(PixelsOffTheSum(*RenderPasses(text, names)), 10) << names.back();
}

/// Paths of one event take the same random numbers whatever comes after: emission and direct light are the
/// image of maxdepth 1.
TEST(RenderedPasses, OfDirectLightAreAShorterRender) {
    for (const std::string& scene :
         {Head("\"path\" \"integer maxdepth\" {}") + "WorldBegin " + kLights + kThings,
          FogScene("\"volpath\" \"integer maxdepth\" {}")}) {
        const auto at = [&](const char* depth) {
            std::string text = scene;
            return text.replace(text.find("{}"), 2, depth);
        };
        const auto image = RenderPasses(at("6"), {"emission", "direct"});
        const auto shorter = test::RenderText(at("1"));
        int off = 0;
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x)
                for (int c = 0; c < 3; ++c) {
                    const float sum = image->Get({x, y}, 3 + c) + image->Get({x, y}, 6 + c);
                    const float value = shorter->Get({x, y}, c);
                    off += std::abs(sum - value) > 1e-5f * (std::abs(value) + 0.1f);
                }
        EXPECT_EQ(off, 0);
    }
}

double MeanOf(const Image& image, const std::string& layer) {
    double sum = 0;
    const int first = image.FindChannel(layer + ".R");
    EXPECT_GE(first, 0) << layer;
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x)
            for (int c = 0; c < 3; ++c) sum += double(image.Get({x, y}, first + c));
    return sum / (3 * kSide * kSide);
}

/// A group's layer against the image under its lights alone: 64 samples in 576 pixels leave less than 1 % of
/// noise in the means of either, and lights that are told apart wrongly change them by tens of percent.
TEST(RenderedPasses, OfALightGroupAreTheImageUnderIt) {
    // The lamp is there, lit or not.
    const auto scene = [](const std::string& lights, bool isLampLit) {
        return Head("\"volpath\"", "", 64) + "WorldBegin " + lights + "AttributeBegin " +
               (isLampLit ? "AreaLightSource \"diffuse\" \"rgb L\" [2 2 2] " : "") +
               "Translate -2 1 -1 Shape \"sphere\" \"float radius\" .4 AttributeEnd "
               "Material \"coateddiffuse\" Shape \"sphere\"";
    };
    const std::string key =
                          "LightSource \"point\" \"point3 from\" [1 3 -4] \"rgb I\" [9 9 9] \"string group\" "
                          "\"key\" ",
                      sky = "LightSource \"infinite\" \"rgb L\" [.5 .5 .5] \"string group\" \"sky\" ";
    const auto image = RenderPasses(scene(key + sky, true), {"lightgroups"});
    for (const auto& [layer, text] : {std::pair("lightgroup.key", scene(key, false)),
                                      {"lightgroup.sky", scene(sky, false)},
                                      {"nolightgroup", scene("", true)}})
        EXPECT_NEAR(MeanOf(*image, layer) / MeanOf(*RenderPasses(text, {"lpe:all=C.*"}), "all"), 1, 0.05)
            << layer;
}

/// What a rough coat reflects is glossy and what comes from below is diffuse, at each wavelength: the glossy
/// pass of a stack over a coloured base is the image of the same stack over black, in all three components.
/// Under lights that are found by scattered rays alone, by light samples alone, and by both. Noise of the
/// means is below 2 %; a base that counted as glossy would add more than 100 %.
TEST(RenderedPasses, TellACoatFromItsBase) {
    for (const char* light :
         {"LightSource \"infinite\" ", "LightSource \"point\" \"point3 from\" [1 4 -5] \"rgb I\" [9 9 9] ",
          "AttributeBegin AreaLightSource \"diffuse\" Translate 0 4 -4 Shape \"sphere\" AttributeEnd "})
        for (const char* estimator : {"auto", "bidirectional"}) {
            const auto scene = [&](const char* reflectance) {
                return Head("\"path\" \"integer maxdepth\" 1", "", 128) + "WorldBegin " + light +
                       fmt::format(
                           "Material \"coateddiffuse\" \"float roughness\" .4 \"rgb reflectance\" {} "
                           "\"string "
                           "estimator\" \"{}\" Shape \"sphere\" \"float radius\" 2",
                           reflectance, estimator);
            };
            const auto image = RenderPasses(scene("[.9 .4 .1]"), {"glossy", "diffuse"});
            const auto black = RenderPasses(scene("[0 0 0]"), {"glossy", "diffuse"});
            for (const char* component : {"R", "G", "B"}) {
                const auto mean = [&](const Image& from, const char* layer) {
                    test::RunningMean values;
                    const int c = from.FindChannel(fmt::format("{}.{}", layer, component));
                    for (int y = 0; y < kSide; ++y)
                        for (int x = 0; x < kSide; ++x) values.Add(double(from.Get({x, y}, c)));
                    return values.Mean();
                };
                EXPECT_NEAR(mean(*image, "glossy") / mean(*black, "glossy"), 1, 0.06)
                    << light << estimator << " " << component;
                EXPECT_LT(mean(*black, "diffuse"), 0.02 * mean(*image, "diffuse")) << light << estimator;
            }
        }
}

/// Events are told apart by materials that have one kind each.
TEST(RenderedPasses, KnowTheFirstEvent) {
    const auto means = [](const std::string& material) {
        const auto image = RenderPasses(Head("\"path\"") + "WorldBegin LightSource \"infinite\" " + material +
                                            " Shape \"sphere\" \"float radius\" 3",
                                        {"diffuse", "glossy", "transmission"});
        return std::array{MeanOf(*image, "diffuse") > 0, MeanOf(*image, "glossy") > 0,
                          MeanOf(*image, "transmission") > 0};
    };
    EXPECT_EQ(means("Material \"diffuse\""), (std::array{true, false, false}));
    EXPECT_EQ(means("Material \"conductor\" \"float roughness\" .3"), (std::array{false, true, false}));
    EXPECT_EQ(means("Material \"conductor\""), (std::array{false, true, false}));
    EXPECT_EQ(means("Material \"dielectric\""), (std::array{false, true, true}));
    EXPECT_EQ(means("Material \"diffusetransmission\""), (std::array{true, false, true}));
}

// ---- alpha ------------------------------------------------------------------------------------------------

double AlphaOf(const std::string& scene, int samples) {
    const RenderSetup setup =
        test::BuildText(fmt::format("Camera \"orthographic\" Film \"rgb\" \"integer xresolution\" 8 "
                                    "\"integer yresolution\" 8 Sampler "
                                    "\"independent\" \"integer pixelsamples\" {} PixelFilter \"box\" ",
                                    samples) +
                        scene);
    AovSetup aovSetup;
    aovSetup.pixelBounds = setup.film->PixelBounds();
    aovSetup.spaces = {&setup.film->ColorSpace(), setup.renderFromWorld,
                       setup.scene->Camera().RenderFromCamera()};
    AovBuffer aovs({"alpha"}, aovSetup);
    RenderOptions options;
    options.aovs = &aovs;
    test::RenderAll(setup, options);
    const auto image = aovs.AppendTo(*setup.film->Develop());
    const int channel = image->FindChannel("A");
    double sum = 0;
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x) sum += double(image->Get({x, y}, channel));
    return sum / 64;
}

/// A disk over an area of pi/4 of the screen, interfaces, glass, and media of known transmittance.
/// Tolerances: 4 standard errors of the 64 * 64 samples, which hit or miss.
TEST(Alpha, IsThePartOfCameraRaysThatMeetSomething) {
    const std::string disk = "WorldBegin LightSource \"infinite\" Translate 0 0 4 ";
    EXPECT_NEAR(AlphaOf(disk + "Shape \"disk\"", 64), Pi / 4, 0.026);
    EXPECT_NEAR(AlphaOf(disk + "Material \"dielectric\" Shape \"disk\"", 64), Pi / 4, 0.026);
    EXPECT_EQ(AlphaOf(disk + "Material \"interface\" Shape \"disk\"", 4), 0);
    EXPECT_EQ(AlphaOf("WorldBegin LightSource \"infinite\"", 4), 0);
    const auto fog = [](const std::string& sigma) {
        return "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\" " + sigma +
               " Integrator \"volpath\" WorldBegin LightSource \"infinite\" Translate 0 0 9 Scale 4 4 1 "
               "MediumInterface \"fog\" \"\" Material \"interface\" Shape \"cylinder\" \"float zmin\" -1 "
               "\"float "
               "zmax\" 0 Shape \"disk\" \"float radius\" 1 Translate 0 0 -1 ReverseOrientation Shape "
               "\"disk\"";
    };
    // One unit of the medium in front of all pixels: 1 - e^-0.7, exactly where it only absorbs.
    const double expected = 1 - std::exp(-0.7);
    EXPECT_NEAR(AlphaOf(fog("\"rgb sigma_a\" [.7 .7 .7] \"rgb sigma_s\" [0 0 0]"), 4), expected, 2e-3);
    EXPECT_NEAR(AlphaOf(fog("\"rgb sigma_a\" [.3 .3 .3] \"rgb sigma_s\" [.4 .4 .4]"), 64), expected, 0.035);
}

}  // namespace
}  // namespace lacquer::passes_test
