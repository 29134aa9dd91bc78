// Layered materials in rendered images: all ways to find the light give the same image, and noise falls as
// that of independent samples does.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "integrators/render_fixtures.h"
#include "layered/agreement.h"

namespace lacquer::layered::test::strategies_test {

namespace {

constexpr double kFamily = 1e-3;

// ---- The same image by all strategies -----------------------------------------------------------------

struct Row {
    const char* name;
    std::vector<const char*>
        layers;  ///< materials from the outside in; one that is no layered material alone
    bool transmits = false;
    bool isSmall = false;
};

const std::vector<Row>& Rows() {
    static const std::vector<Row> rows = {
        {"coat_metal",
         {R"("dielectric" "float roughness" 0.1)", R"("conductor" "float roughness" 0.05)"},
         false,
         true},
        {"coat_metal_beckmann",
         {R"("dielectric" "float roughness" 0.1 "string distribution" "beckmann")",
          R"("conductor" "float roughness" 0.1 "string distribution" "beckmann")"}},
        {"rough_coat_metal",
         {R"("dielectric" "float roughness" 0.4)", R"("conductor" "float roughness" 0.2)"}},
        {"smooth_coat_metal", {R"("dielectric")", R"("conductor" "float roughness" 0.1)"}, false, true},
        {"smooth_coat_diffuse", {R"("dielectric")", R"("diffuse" "rgb reflectance" [0.7 0.7 0.7])"}},
        {"coat_mirror", {R"("dielectric" "float roughness" 0.1)", R"("conductor")"}},
        {"coat_diffuse",
         {R"("dielectric" "float roughness" 0.2)", R"("diffuse" "rgb reflectance" [0.8 0.4 0.2])"}},
        {"coat_medium_metal",
         {R"("dielectric" "float roughness" 0.1)",
          R"("slab" "rgb sigma_t" [1 1 1] "rgb albedo" [0.9 0.9 0.9] "string phase" "hg" "float g" 0.5)",
          R"("conductor" "float roughness" 0.1)"},
         false,
         true},
        {"coat_coloured_medium_metal",
         {R"("dielectric" "float roughness" 0.1)",
          R"("slab" "rgb sigma_t" [0.5 1 2] "rgb albedo" [0.5 0.7 0.95] "string phase" "hg" "float g" 0.5)",
          R"("conductor" "float roughness" 0.1)"}},
        {"thick_medium",
         {R"("dielectric" "float roughness" 0.2)",
          R"("slab" "rgb sigma_t" [8 8 8] "rgb albedo" [0.95 0.95 0.95] "string phase" "vmf" "float kappa" 3)",
          R"("diffuse" "rgb reflectance" [0.5 0.5 0.5])"}},
        {"smooth_coat_medium_smooth_mirror",
         {R"("dielectric")", R"("slab" "rgb sigma_t" [1 1 1] "rgb albedo" [1 1 1])", R"("conductor")"}},
        {"fibres_metal",
         {R"("dielectric" "float roughness" 0.1)",
          R"("slab" "rgb sigma_t" [1 1 1] "rgb albedo" [0.9 0.9 0.9] "string phase" "fibre"
             "vector3 orientation" [1 0.5 0] "float stddev" 0.2)",
          R"("conductor" "float roughness" 0.1)"}},
        {"three_interfaces_two_media",
         {R"("dielectric" "float roughness" 0.1)",
          R"("slab" "float eta" 1.5 "rgb sigma_t" [0.5 0.5 0.5] "rgb albedo" [0.9 0.9 0.9])",
          R"("dielectric" "float roughness" 0.05)",
          R"("slab" "float eta" 1.2 "rgb sigma_t" [0.5 0.5 0.5] "rgb albedo" [0.8 0.8 0.8])",
          R"("conductor" "float roughness" 0.1)"}},
        {"anisotropic",
         {R"("dielectric" "float uroughness" 0.02 "float vroughness" 0.2)",
          R"("conductor" "float uroughness" 0.2 "float vroughness" 0.05 "float rotation" 30)"}},
        {"pane",
         {R"("dielectric" "float roughness" 0.1)", R"("slab" "float eta" 1.5)",
          R"("dielectric" "float roughness" 0.05)"},
         true,
         true},
        {"pane_one_side_smooth",
         {R"("dielectric")", R"("slab" "float eta" 1.5)", R"("dielectric" "float roughness" 0.1)"},
         true},
        {"pane_with_medium",
         {R"("dielectric" "float roughness" 0.1)",
          R"("slab" "float eta" 1.5 "rgb sigma_t" [1 1 1] "rgb albedo" [0.95 0.95 0.95])",
          R"("dielectric" "float roughness" 0.1)"},
         true},
        {"sheet_of_medium",
         {R"("interface")",
          R"("slab" "float eta" 1 "rgb sigma_t" [1 1 1] "rgb albedo" [0.95 0.95 0.95] "string phase" "hg" "float g" 0.3)",
          R"("interface")"},
         true},
        {"coateddiffuse", {R"("coateddiffuse" "float roughness" 0.1)"}, false, true},
        {"coatedconductor",
         {R"("coatedconductor" "float interface.roughness" 0.1 "float conductor.roughness" 0.1)"}},
    };
    return rows;
}

std::string MaterialText(const Row& row, const std::string& pdf) {
    const std::string choice = fmt::format(" \"string pdf\" \"{}\"", pdf);
    if (row.layers.size() == 1) return fmt::format("Material {}{}\n", row.layers[0], choice);
    std::string text, names;
    for (size_t i = 0; i < row.layers.size(); ++i) {
        text += fmt::format("MakeNamedMaterial \"layer{}\" \"string type\" {}\n", i, row.layers[i]);
        names += fmt::format("\"layer{}\" ", i);
    }
    return text + fmt::format("Material \"layered\" \"string stack\" [{}]{}\n", names, choice);
}

struct Strategy {
    const char *name, *integrator, *pdf;
    float lightScale = 1;
};
constexpr Strategy kBoth = {"both, pdf approximate", R"("path")", "approximate"};
constexpr Strategy kBothUnbiased = {"both, pdf unbiased", R"("path")", "unbiased"};
constexpr Strategy kSampling = {"sampling", R"("simplepath" "bool samplelights" false)", "approximate"};
constexpr Strategy kLights = {"lights", R"("simplepath")", "approximate"};

constexpr int kSide = 16;

/// A ball on a floor of the material, before a lamp; and a lamp below the floor where light passes.
std::unique_ptr<Image> RenderRow(const Row& row, const Strategy& strategy, int samples, uint64_t seed) {
    constexpr const char* kView = R"(
LookAt 0 4 -3  0 0.2 0  0 1 0
Camera "perspective" "float fov" 28
Film "rgb" "integer xresolution" {0} "integer yresolution" {0}
PixelFilter "box"
Sampler "independent" "integer pixelsamples" {1} "integer seed" {2}
Integrator {3} "integer maxdepth" 3
WorldBegin
AttributeBegin
    AreaLightSource "diffuse" "float scale" {4} "bool twosided" true
    Translate 0 4 3 Rotate 90 1 0 0 Shape "disk" "float radius" 4
AttributeEnd
)";
    constexpr const char* kLowerLamp = R"(
AttributeBegin
    AreaLightSource "diffuse" "float scale" {}
    Translate 0 -1.5 0.5 Rotate -90 1 0 0 Shape "disk" "float radius" 2.5
AttributeEnd
)";
    constexpr const char* kObjects = R"(
AttributeBegin Translate 0 0.6 0 Shape "sphere" "float radius" 0.6 AttributeEnd
Rotate -90 1 0 0 Shape "disk" "float radius" 4
)";
    std::string text =
        fmt::format(kView, kSide, samples, seed % 100000000, strategy.integrator, strategy.lightScale);
    if (row.transmits) text += fmt::format(kLowerLamp, strategy.lightScale);
    text += MaterialText(row, strategy.pdf) + kObjects;
    return RenderText(text);
}

struct Found {
    Outcome outcome;
    double difference = 0, error = 0;  ///< of the mean luminances, relative
};

/// A strategy's image of a row, which others are compared with.
struct Reference {
    Strategy strategy;
    std::unique_ptr<Image> image;
};
Reference MakeReference(const Row& row, const Strategy& strategy, int samples, uint64_t seed) {
    return {strategy, RenderRow(row, strategy, samples, seed)};
}

/// Pixel by pixel, so that what the image shows does not count as noise.
Found Compare(const Row& row, const Strategy& a, const Reference& reference, int samples, uint64_t seed) {
    const Strategy& b = reference.strategy;
    const auto imageA = RenderRow(row, a, samples, Hash(seed, 1));
    const Image* imageB = reference.image.get();
    RunningMean difference;
    for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x)
            difference.Add(LuminanceAt(*imageA, {x, y}) - LuminanceAt(*imageB, {x, y}));
    const double mean = PixelLuminance(*imageB).Mean();
    return {ZTest(difference, 0, 0, fmt::format("{} against {} ({})", a.name, b.name, row.name)),
            difference.Mean() / mean, difference.StandardError() / mean};
}
Found Compare(const Row& row, const Strategy& a, const Strategy& b, int samples, uint64_t seed) {
    return Compare(row, a, MakeReference(row, b, samples, Hash(seed, 2)), samples, seed);
}

int SamplesPerPixel() { return IsFullRun() ? 4096 : Scaled(256); }

// Power: the relative standard errors of the differences are 0.5 to 1.3 % in the fast subset (2 % for lights
// behind a pane) and a quarter of that in the full set; 4.3 of them are found. All strategies of a row are
// compared with one image; what deviates is judged with new ones.
TEST(LayeredStrategies, SamplingLightsAndBothGiveTheSameImage) {
    std::vector<const Row*> rows;
    for (const Row& row : Rows())
        if (row.isSmall || IsFullRun()) rows.push_back(&row);
    const Strategy others[] = {kSampling, kLights, kBothUnbiased};
    const double alpha = SidakAlpha(kFamily, int(rows.size() * std::size(others)));
    double worstError = 0;
    for (const Row* row : rows) {
        const Reference both =
            MakeReference(*row, kBoth, SamplesPerPixel(), SeedOf(FullTestName() + row->name));
        for (const Strategy& a : others) {
            const std::string name = FullTestName() + row->name + a.name;
            const Found first = Compare(*row, a, both, SamplesPerPixel(), SeedOf(name));
            EXPECT_TRUE(PassesAt(
                SeedOf(name), name, alpha, first.outcome,
                [&](uint64_t seed) { return Compare(*row, a, kBoth, SamplesPerPixel(), seed).outcome; }))
                << fmt::format("{}: {:+.2f} % +- {:.2f} %", row->name, 100 * first.difference,
                               100 * first.error);
            RecordProperty(fmt::format("{}: {}", row->name, a.name),
                           fmt::format("{:+.2f} % +- {:.2f} %", 100 * first.difference, 100 * first.error));
            worstError = std::max(worstError, first.error);
        }
    }
    RecordProperty("worst relative error", fmt::format("{:.3f} %", 100 * worstError));
}

// Values 3 % above what sampling draws. In "simplepath" all light is found by values, so that a lamp 3 %
// brighter is what a BxDF with that mistake would show. Power: 9 standard errors.
TEST(LayeredStrategies, NegativeControlValuesThreePercentTooBrightAreFound) {
    Strategy brighter = kLights;
    const bool isQuick = Scaled(8) != 8;  // under sanitizers only a larger mistake shows
    brighter.lightScale = isQuick ? 1.12f : 1.03f;
    const Row& row = Rows()[2];
    const Found found = Compare(row, brighter, kSampling, Scaled(3072), SeedOf(FullTestName()));
    EXPECT_LT(found.outcome.pValue, SidakAlpha(kFamily, int(3 * Rows().size())))
        << found.outcome.details << fmt::format(", {:.2f} %", 100 * found.error);
}

// ---- Noise --------------------------------------------------------------------------------------------

/// A flat coated wall, seen and lit from one direction each: all pixels see the same surface.
std::vector<double> WallPixels(int side, int samples, uint64_t seed) {
    constexpr const char* kScene = R"(
LookAt 0 0 -3  0 0 0  0 1 0
Camera "orthographic"
Film "rgb" "integer xresolution" {0} "integer yresolution" {0}
PixelFilter "box"
Sampler "independent" "integer pixelsamples" {1} "integer seed" {2}
Integrator "path" "integer maxdepth" 1
WorldBegin
LightSource "distant" "point3 from" [1 1 -2]
Material "coateddiffuse" "float roughness" 0.3 "rgb reflectance" [0.5 0.5 0.5] "string estimator" "bidirectional"
Shape "disk" "float radius" 9
)";
    const auto image = RenderText(fmt::format(kScene, side, samples, seed % 100000000));
    std::vector<double> pixels;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) pixels.push_back(LuminanceAt(*image, {x, y}));
    return pixels;
}

/// Are these the means of `samples` independent draws of this variance each? Says so by their variance and by
/// the correlation of neighbours.
struct Noise {
    double varianceZ = 0, correlationZ = 0;
    double ratio = 0;  ///< of the variance to the expected one

    bool IsIndependent() const { return std::abs(varianceZ) < 4.5 && std::abs(correlationZ) < 4.5; }
};
Noise NoiseOf(const std::vector<double>& pixels, double sampleVariance, double relativeVarianceError,
              int samples) {
    RunningMean mean;
    for (const double p : pixels) mean.Add(p);
    double product = 0;
    for (size_t i = 0; i + 1 < pixels.size(); ++i)
        product += (pixels[i] - mean.Mean()) * (pixels[i + 1] - mean.Mean());
    const double n = double(pixels.size());
    Noise noise;
    noise.ratio = mean.Variance() * samples / sampleVariance;
    noise.varianceZ = (noise.ratio - 1) / std::hypot(std::sqrt(2 / (n - 1)), relativeVarianceError);
    noise.correlationZ = mean.Variance() > 0 ? product / (n * mean.Variance()) * std::sqrt(n) : 1e9;
    return noise;
}

struct SampleVariance {
    double mean = 0, meanError = 0, variance = 0, relativeError = 0;
};
SampleVariance VarianceOf(const std::vector<double>& values) {
    RunningMean mean;
    for (const double v : values) mean.Add(v);
    RunningMean squares;
    for (const double v : values) squares.Add(Sqr(v - mean.Mean()));
    return {mean.Mean(), mean.StandardError(), squares.Mean(), squares.StandardError() / squares.Mean()};
}

// The variance over pixels times the number of samples is that of one sample. Power: 144 pixels tell a
// variance 1.55 times too large (4.5 sigma), so a standard error 1.25 times too large. False alarms: 7e-6 for
// each of the nine numbers.
TEST(LayeredNoise, FallsLikeThatOfIndependentSamples) {
    const std::string name = FullTestName();
    const SampleVariance single = VarianceOf(WallPixels(256, 1, SeedOf(name)));
    const int side = IsFullRun() ? 32 : 12;
    for (const int samples : {64, 512, Scaled(4096)}) {
        const std::vector<double> pixels = WallPixels(side, samples, SeedOf(name + std::to_string(samples)));
        const Noise noise = NoiseOf(pixels, single.variance, single.relativeError, samples);
        EXPECT_TRUE(noise.IsIndependent()) << fmt::format(
            "{} samples: variance {:.2f} of the expected one ({:+.1f} sigma), correlation {:+.1f} sigma",
            samples, noise.ratio, noise.varianceZ, noise.correlationZ);
        const SampleVariance all = VarianceOf(pixels);
        EXPECT_NEAR(all.mean, single.mean, 4.5 * std::hypot(all.meanError, single.meanError)) << samples;
        RecordProperty(
            fmt::format("{} samples", samples),
            fmt::format(
                "variance {:.3f} of the expected one, neighbours {:+.2f} sigma, mean {:.6f} +- {:.6f}",
                noise.ratio, noise.correlationZ, all.mean, all.meanError));
    }
}

// Numbers that are a function of the two directions: the noise of a pixel stays. Where all directions are the
// same the image even has none, and is wrong.
TEST(LayeredNoise, NegativeControlFrozenRandomnessIsFound) {
    Arena arena;
    const StackCase wall{.name = "",
                         .layers = {Dielectric(std::sqrt(0.3f), 1.5f), Absorber(0.01f), Diffuse(0.5f)}};
    const LayeredBxDF* bxdf = wall.MakeBxDF(arena, {.estimator = FindEstimator("bidirectional")});
    enum class Stream { Free, ByPixel, Constant };
    const auto pixelsOf = [&](Stream stream, int numPixels, int samples) {
        Rng free(SeedOf(FullTestName()));
        std::vector<double> pixels;
        for (int i = 0; i < numPixels; ++i) {
            // Pixels see slightly different directions, as those of a perspective camera do.
            const Vec3 wo = Normalize(Vec3(1e-5f * float(i), 0, 1)), wi = Normalize(Vec3(1, 1, 2));
            double sum = 0;
            for (int k = 0; k < samples; ++k) {
                Rng frozen(stream == Stream::Constant ? 1 : Hash(wo, wi));
                const BxDFContext context{TransportMode::Radiance, Lobes::BothSides,
                                          stream == Stream::Free ? &free : &frozen, false};
                sum += double(bxdf->Evaluate(wo, wi, context).f.Average());
            }
            pixels.push_back(sum / samples);
        }
        return pixels;
    };
    const SampleVariance single = VarianceOf(pixelsOf(Stream::Free, 30000, 1));
    const auto noiseOf = [&](Stream stream) {
        return NoiseOf(pixelsOf(stream, 144, 64), single.variance, single.relativeError, 64);
    };
    EXPECT_TRUE(noiseOf(Stream::Free).IsIndependent());
    EXPECT_FALSE(noiseOf(Stream::ByPixel).IsIndependent());
    EXPECT_GT(noiseOf(Stream::ByPixel).ratio, 16);
    EXPECT_FALSE(noiseOf(Stream::Constant).IsIndependent());
}

}  // namespace
}  // namespace lacquer::layered::test::strategies_test
