#include "pbrt/film/aov.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "pbrt/base/material.h"
#include "support/scoped_registration.h"

namespace lacquer::aov_test {
namespace {

const Bounds2i kBounds{{10, 20}, {12, 23}};

/// The channels that `buffer` appends to a black image, of one pixel.
std::vector<float> ExtraChannels(const AovBuffer& buffer, Int2 pixel) {
    Image rgb({kBounds.Width(), kBounds.Height()}, {"R", "G", "B"});
    rgb.dataWindow = kBounds;
    const auto image = buffer.AppendTo(rgb);
    std::vector<float> values;
    for (int c = 3; c < image->NumChannels(); ++c) values.push_back(image->Get(pixel - kBounds.min, c));
    return values;
}
AovSetup SetupOf(const SceneNames* names = nullptr) {
    AovSetup setup;
    setup.pixelBounds = kBounds;
    setup.spaces.color = &ColorSpace::SRGB();
    setup.names = names;
    return setup;
}
AovBuffer MakeBuffer(const std::vector<std::string>& names) { return AovBuffer(names, SetupOf()); }
FirstHit HitAt(Point3 p, Normal3 n, Point2 uv, float albedo = 0) {
    FirstHit hit;
    hit.hit = true;
    hit.p = p;
    hit.n = n;
    hit.ns = n;
    hit.uv = uv;
    hit.albedo = SampledSpectrum(albedo);
    return hit;
}
SampledWavelengths Lambda(float u = 0.5f) { return SampledWavelengths::SampleVisible(u); }

TEST(AovBuffer, KnowsWhatItWasAskedFor) {
    EXPECT_EQ(AovBuffer::Names(),
              (std::vector<std::string>{"albedo", "alpha", "depth", "motion", "ng", "normal", "position",
                                        "samples", "uv", "variance", "object", "material", "cryptoobject",
                                        "cryptomaterial", "half"}));
    EXPECT_TRUE(AovBuffer::NeedsHalves({"depth", "half"}));
    EXPECT_FALSE(AovBuffer::NeedsHalves({"depth"}));
    const auto needs = [](const std::vector<std::string>& names) { return MakeBuffer(names).Needs(); };
    EXPECT_FALSE(needs({"variance", "samples"}).any);
    EXPECT_TRUE(needs({"samples", "uv"}).any);
    EXPECT_FALSE(needs({"samples", "uv"}).albedo);
    EXPECT_TRUE(needs({"albedo"}).albedo && needs({"albedo"}).any);
    EXPECT_TRUE(needs({"cryptoobject"}).any);
    EXPECT_TRUE(needs({"slope"}).slopes);
    EXPECT_TRUE(needs({"motion"}).motion);
    EXPECT_FALSE(needs({"motion"}).any);
    EXPECT_FALSE(needs({"ng"}).slopes);
    EXPECT_TRUE(AovBuffer::NeedsSceneNames({"depth", "material"}));
    EXPECT_FALSE(AovBuffer::NeedsSceneNames({"depth", "albedo"}));
}

TEST(AovBuffer, NamesItsChannels) {
    Image rgb({2, 3}, {"R", "G", "B"});
    rgb.Set({1, 2}, 2, 7);
    rgb.dataWindow = kBounds;
    rgb.fullResolution = {50, 60};
    rgb.metadata["samples"] = 4;
    rgb.SetColorSpace(&ColorSpace::SRGB());
    const SceneNames names{{"kettle"}, {}};
    std::vector<std::string> all = AovBuffer::Names();
    all.push_back("depth");  // twice: once in the image
    AovSetup setup = SetupOf(&names);
    setup.cryptomatteRanks = 2;
    const auto image = AovBuffer(all, setup).AppendTo(rgb);
    EXPECT_EQ(fmt::format("{}", fmt::join(image->Channels(), " ")),
              "R G B Albedo.R Albedo.G Albedo.B A Z motion.X motion.Y N.X N.Y N.Z Ns.X Ns.Y Ns.Z P.X P.Y P.Z "
              "samples u v Variance.Y Half.Albedo.R Half.Albedo.G Half.Albedo.B Half.Ns.X "
              "Half.Ns.Y Half.Ns.Z Half.Z Half.samples object.id CryptoObject00.r CryptoObject00.g "
              "CryptoObject00.b CryptoObject00.a material.id CryptoMaterial00.r "
              "CryptoMaterial00.g CryptoMaterial00.b CryptoMaterial00.a");
    EXPECT_EQ(image->Get({1, 2}, 2), 7);
    EXPECT_EQ(image->dataWindow, kBounds);
    EXPECT_EQ(image->fullResolution, Int2(50, 60));
    EXPECT_EQ(std::get<int>(image->metadata.at("samples")), 4);
    EXPECT_EQ(std::get<std::string>(image->metadata.at("objectManifest")), "{\"kettle\":1}");
    EXPECT_EQ(image->ColorSpace(), &ColorSpace::SRGB());
    for (const char* narrow : {"R", "Albedo.R", "Ns.X", "N.Z"})
        EXPECT_FALSE(image->floatChannels.contains(narrow));
    for (const char* wide : {"P.X", "Z", "u", "samples", "object.id", "CryptoMaterial00.r"})
        EXPECT_TRUE(image->floatChannels.contains(wide)) << wide;
}

void AddTime(const AovSample& s, double* terms) { terms[0] = double(s.hit.time); }
void DevelopTime(const ColorSpace&, const AovCounts& counts, const double* sums, float* out) {
    out[0] = float(sums[0] / counts.hits);
}
AovOutput Time() {
    return {.channels = {"T"}, .numSums = 1, .needs = {.any = true}, .add = AddTime, .develop = DevelopTime};
}

TEST(AovBuffer, ANewOutputIsFoundByItsOwnLine) {
    const test::ScopedRegistration<AovKind> time("time", Time);
    const std::vector<std::string> names = AovBuffer::Names();
    EXPECT_NE(std::find(names.begin(), names.end(), "time"), names.end());
    AovBuffer buffer = MakeBuffer({"samples", "time", "samples"});
    FirstHit hit = HitAt({0, 0, 5}, {0, 0, 1}, {0, 0});
    for (const float t : {0.25f, 0.75f}) {
        hit.time = t;
        buffer.Add({11, 22}, hit, SampledSpectrum(1), Lambda());
    }
    EXPECT_EQ(ExtraChannels(buffer, {11, 22}), (std::vector<float>{2, 0.5f}));
}

TEST(AovBuffer, LeavesChannelsThatTheImageHas) {
    Image film({2, 3}, {"R", "G", "B", "Z"});
    film.Set({1, 2}, 3, 7);
    AovBuffer buffer = MakeBuffer({"depth", "samples"});
    buffer.Add({11, 22}, HitAt({0, 0, 5}, {0, 0, 1}, {0, 0}), SampledSpectrum(1), Lambda());
    const auto image = buffer.AppendTo(film);
    EXPECT_EQ(image->Channels(), (std::vector<std::string>{"R", "G", "B", "Z", "samples"}));
    EXPECT_EQ(image->Get({1, 2}, 3), 7);
    EXPECT_EQ(image->Get({1, 2}, 4), 1);
}

TEST(AovBuffer, GeometryIsAMeanOverHits) {
    AovBuffer buffer = MakeBuffer({"position", "uv", "ng", "samples", "depth"});
    const Int2 pixel(11, 22);
    buffer.Add(pixel, HitAt({1, 2, 3}, {0, 0, 1}, {0.25f, 0.5f}), SampledSpectrum(1), Lambda());
    buffer.Add(pixel, HitAt({3, 2, 5}, {0, 1, 0}, {0.75f, 1}), SampledSpectrum(1), Lambda());
    buffer.Add(pixel, {}, SampledSpectrum(1), Lambda());
    const float diagonal = std::sqrt(0.5f);
    const std::vector<float> expected = {2, 2, 4, 0.5f, 0.75f, 0, diagonal, diagonal, 3, 4};
    const std::vector<float> values = ExtraChannels(buffer, pixel);
    ASSERT_EQ(values.size(), expected.size());
    for (size_t i = 0; i < values.size(); ++i) EXPECT_FLOAT_EQ(values[i], expected[i]) << i;
    // Pixels that saw nothing are zero.
    for (const float v : ExtraChannels(buffer, {10, 20})) EXPECT_EQ(v, 0);
}

TEST(AovBuffer, PositionsAreInTheWorldAndDepthsBeforeTheCamera) {
    AovSetup setup = SetupOf();
    setup.spaces.renderFromWorld =
        (Transform::Translate({10, 0, 0}) * Transform::Rotate(90, {0, 0, 1})).Inverse();
    setup.spaces.renderFromCamera = AnimatedTransform(Transform::Translate({0, 0, -5}));
    const auto values = [&] {
        AovBuffer buffer({"position", "depth", "normal"}, setup);
        buffer.Add({10, 20}, HitAt({1, 0, 2}, {1, 0, 0}, {0, 0}), SampledSpectrum(1), Lambda());
        return ExtraChannels(buffer, {10, 20});
    };
    const std::vector<float> asked = {10, 1, 2, 7, 0, 1, 0}, got = values();
    ASSERT_EQ(got.size(), asked.size());
    for (size_t i = 0; i < asked.size(); ++i) EXPECT_NEAR(got[i], asked[i], 1e-6f) << i;
    setup.spaces.cameraSpace = true;
    const std::vector<float> camera = {1, 0, 7, 7, 1, 0, 0}, inCamera = values();
    for (size_t i = 0; i < camera.size(); ++i) EXPECT_NEAR(inCamera[i], camera[i], 1e-6f) << i;
}

TEST(AovBuffer, DepthIsThatBeforeTheCameraWhereItStoodThen) {
    AovSetup setup = SetupOf();
    setup.spaces.renderFromCamera = AnimatedTransform(Transform(), 0, Transform::Translate({0, 0, -8}), 1);
    AovBuffer buffer({"depth"}, setup);
    for (const float time : {0.f, 0.5f}) {
        FirstHit hit = HitAt({0, 0, 2}, {0, 0, 1}, {0, 0});
        hit.time = time;
        buffer.Add({10, 20}, hit, SampledSpectrum(1), Lambda());
    }
    EXPECT_NEAR(ExtraChannels(buffer, {10, 20})[0], (2 + 6) / 2.f, 1e-5f);
}

TEST(AovBuffer, SlopesAreAbsoluteMeans) {
    AovBuffer buffer = MakeBuffer({"slope"});
    for (const float z : {0.25f, -0.75f}) {
        FirstHit hit = HitAt({0, 0, 2}, {0, 0, 1}, {0, 0});
        hit.dpdx = {9, 9, z};
        hit.dpdy = {9, 9, 2 * z};
        buffer.Add({10, 20}, hit, SampledSpectrum(1), Lambda());
    }
    EXPECT_EQ(ExtraChannels(buffer, {10, 20}), (std::vector<float>{0.25f, 0.5f}));
}

TEST(AovBuffer, VarianceIsThatOfTheSamplesLuminance) {
    AovBuffer buffer = MakeBuffer({"variance"});
    std::vector<double> y;
    double mean = 0;
    for (int i = 0; i < 40; ++i) {
        const SampledWavelengths lambda = Lambda(float(i) / 40);
        const SampledSpectrum L(1000 + float(i % 7));
        y.push_back(0);
        for (int k = 0; k < kNumWavelengths; ++k)
            y.back() +=
                double(L[k]) * double(CieY().Evaluate(lambda[k])) / double(lambda.Pdf()[k]) / kNumWavelengths;
        mean += y.back() / 40;
        buffer.Add({10, 20}, {}, L, lambda);
    }
    double variance = 0;
    for (const double v : y) variance += (v - mean) * (v - mean) / 39;
    EXPECT_NEAR(double(ExtraChannels(buffer, {10, 20})[0]) / variance, 1, 1e-5);
    // One sample has none.
    buffer.Add({11, 20}, {}, SampledSpectrum(1), Lambda());
    EXPECT_EQ(ExtraChannels(buffer, {11, 20})[0], 0);
}

TEST(AovBuffer, SensorVarianceIsOfHitsAndRelativeToTheirMean) {
    AovBuffer buffer = MakeBuffer({"sensorvariance"});
    const FirstHit hit = HitAt({0, 0, 0}, {0, 0, 1}, {0, 0});
    for (const float x : {1.f, 2.f, 6.f})
        buffer.Add({10, 20}, hit, SampledSpectrum(1), Lambda(), {x, 2 * x, 0});
    buffer.Add({10, 20}, {}, SampledSpectrum(1), Lambda(), {100, 100, 100});
    // Deviations of 1, 2, 6 from 3: 4 + 1 + 9 = 14, over two.
    const std::vector<float> expected = {7, 28, 0, 7 / 9.f, 28 / 36.f, 0};
    const std::vector<float> values = ExtraChannels(buffer, {10, 20});
    for (size_t i = 0; i < 6; ++i) EXPECT_FLOAT_EQ(values[i], expected[i]) << i;
}

TEST(AovBuffer, AlbedoIsAColorUnderWhiteAveragedOverAllSamples) {
    AovBuffer buffer = MakeBuffer({"albedo"});
    constexpr int kSamples = 2000;
    for (int i = 0; i < kSamples; ++i) {
        const SampledWavelengths lambda = Lambda((float(i / 2) + 0.5f) / (kSamples / 2));
        FirstHit hit = HitAt({0, 0, 0}, {0, 0, 1}, {0, 0});
        hit.hit = i % 2 == 0;  // half of the pixel is empty
        hit.albedo = SampleRGB(ColorSpace::SRGB(), {0.8f, 0.4f, 0.2f}, SpectrumKind::Albedo, lambda);
        buffer.Add({10, 20}, hit, SampledSpectrum(1), lambda);
    }
    const std::vector<float> values = ExtraChannels(buffer, {10, 20});
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(values[size_t(c)], RGB(0.4f, 0.2f, 0.1f)[c], 2e-3f);
}

TEST(AovBuffer, AGreyAlbedoHasNoNoiseOfItsWavelengths) {
    AovBuffer buffer = MakeBuffer({"albedo"});
    for (const float u : {0.1f, 0.45f, 0.47f})
        buffer.Add({10, 20}, HitAt({0, 0, 0}, {0, 0, 1}, {0, 0}, 0.6f), SampledSpectrum(1), Lambda(u));
    // One wavelength only, which Z does not see.
    SampledWavelengths red = Lambda(0.999f);
    red.TerminateSecondary();
    buffer.Add({11, 20}, HitAt({0, 0, 0}, {0, 0, 1}, {0, 0}, 0.6f), SampledSpectrum(1), red);
    for (const Int2 pixel : {Int2(10, 20), Int2(11, 20)})
        for (const float v : ExtraChannels(buffer, pixel)) EXPECT_NEAR(v, 0.6f, 1e-5f);
}

/// A material that only its address tells from others.
const PlaceholderMaterial kMaterials[3];

FirstHit HitOf(int object, const Material* material = nullptr) {
    FirstHit hit = HitAt({0, 0, 0}, {0, 0, 1}, {0, 0});
    hit.object = object;
    hit.material = material;
    return hit;
}

TEST(AovBuffer, IdsAreThoseThatMostSamplesSee) {
    SceneNames names;
    names.objects = {"cup", "tree", "tree#2"};
    names.materials = {{&kMaterials[0], "gold"}, {&kMaterials[1], "wood"}};
    AovBuffer buffer({"object", "material"}, SetupOf(&names));
    const auto add = [&](Int2 pixel, const FirstHit& hit) {
        buffer.Add(pixel, hit, SampledSpectrum(1), Lambda());
    };
    for (const int object : {0, 2, 2, 1}) add({10, 20}, HitOf(object, &kMaterials[object / 2]));
    EXPECT_EQ(ExtraChannels(buffer, {10, 20}), (std::vector<float>{3, 1}));
    // Nothing takes part, and loses ties.
    for (const bool hit : {false, false, true}) add({11, 20}, hit ? HitOf(0, &kMaterials[0]) : FirstHit());
    EXPECT_EQ(ExtraChannels(buffer, {11, 20}), (std::vector<float>{0, 0}));
    add({11, 20}, HitOf(0, &kMaterials[0]));
    EXPECT_EQ(ExtraChannels(buffer, {11, 20}), (std::vector<float>{1, 1}));
    // What has no name counts as nothing.
    add({10, 21}, HitOf(-1, &kMaterials[2]));
    add({10, 22}, HitOf(3, nullptr));
    EXPECT_EQ(ExtraChannels(buffer, {10, 21}), (std::vector<float>{0, 0}));
    EXPECT_EQ(ExtraChannels(buffer, {10, 22}), (std::vector<float>{0, 0}));
}

}  // namespace
}  // namespace lacquer::aov_test
