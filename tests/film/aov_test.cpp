#include "pbrt/film/aov.h"

#include <gtest/gtest.h>

namespace lacquer {
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
AovBuffer MakeBuffer(const std::vector<std::string>& names, const Transform& worldFromRender = {},
                     const Transform& cameraFromRender = {}) {
    return AovBuffer(names, kBounds, ColorSpace::SRGB(), worldFromRender, cameraFromRender);
}
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
    EXPECT_EQ(AovBuffer::Names().size(), 8u);
    const AovBuffer few = MakeBuffer({"variance", "samples"});
    EXPECT_TRUE(few.Wants("samples"));
    EXPECT_FALSE(few.Wants("depth"));
    EXPECT_FALSE(few.WantsFirstHit());
    EXPECT_TRUE(MakeBuffer({"samples", "uv"}).WantsFirstHit());
}

TEST(AovBuffer, NamesItsChannels) {
    Image rgb({2, 3}, {"R", "G", "B"});
    rgb.Set({1, 2}, 2, 7);
    rgb.dataWindow = kBounds;
    rgb.fullResolution = {50, 60};
    rgb.metadata["samples"] = 4;
    rgb.SetColorSpace(&ColorSpace::SRGB());
    const auto image = MakeBuffer(AovBuffer::Names()).AppendTo(rgb);
    const std::vector<std::string> expected = {
        "R",    "G",    "B",   "Albedo.R", "Albedo.G", "Albedo.B", "N.X", "N.Y", "N.Z",        "Ns.X",
        "Ns.Y", "Ns.Z", "P.X", "P.Y",      "P.Z",      "Z",        "u",   "v",   "Variance.Y", "samples"};
    EXPECT_EQ(image->Channels(), expected);
    EXPECT_EQ(image->Get({1, 2}, 2), 7);
    EXPECT_EQ(image->dataWindow, kBounds);
    EXPECT_EQ(image->fullResolution, Int2(50, 60));
    EXPECT_EQ(std::get<int>(image->metadata.at("samples")), 4);
    EXPECT_EQ(image->ColorSpace(), &ColorSpace::SRGB());
}

TEST(AovBuffer, GeometryIsAMeanOverHits) {
    AovBuffer buffer = MakeBuffer({"position", "uv", "normal", "samples", "depth"});
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
    AovBuffer buffer = MakeBuffer({"position", "depth", "shadingnormal"},
                                  Transform::Translate({10, 0, 0}) * Transform::Rotate(90, {0, 0, 1}),
                                  Transform::Translate({0, 0, 5}));
    buffer.Add({10, 20}, HitAt({1, 0, 2}, {1, 0, 0}, {0, 0}), SampledSpectrum(1), Lambda());
    const std::vector<float> expected = {10, 1, 2, 7, 0, 1, 0}, values = ExtraChannels(buffer, {10, 20});
    for (size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(values[i], expected[i], 1e-6f) << i;
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

/// Reflects 70 % into one direction.
class Mirror final : public BxDF {
  public:
    Lobes Flags() const override { return Lobes::SpecularReflection; }
    BxDFValue Evaluate(Vec3, Vec3, const BxDFContext&) const override { return {}; }
    std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom& u, const BxDFContext&) const override {
        EXPECT_TRUE(u.lobe >= 0 && u.lobe < 1 && u.direction.x >= 0 && u.direction.x < 1 &&
                    u.direction.y >= 0 && u.direction.y < 1);
        BxDFSample s;
        s.wi = {-wo.x, -wo.y, wo.z};
        s.weight = SampledSpectrum(0.7f);
        return s;
    }
};

TEST(FirstHitRecorder, TurnsNormalsToTheViewerAndEstimatesTheAlbedo) {
    SurfaceInteraction si;
    si.p = {1, 2, 3};
    si.n = {0, 0, -1};
    si.shading.n = Normalize(Vec3(0, 0.5f, -1));
    si.wo = {0, 0, 1};
    si.uv = {0.1f, 0.2f};
    const Mirror mirror;
    FirstHitRecorder recorder(true);
    EXPECT_FALSE(recorder.Last().hit);
    recorder.Record(si, mirror, {0, 0, 1});
    EXPECT_TRUE(recorder.Last().hit);
    EXPECT_EQ(recorder.Last().p, si.p);
    EXPECT_EQ(recorder.Last().n, -si.n);
    EXPECT_EQ(recorder.Last().ns, -si.shading.n);
    EXPECT_EQ(recorder.Last().uv, si.uv);
    EXPECT_NEAR(recorder.Last().albedo[0], 0.7f, 1e-6f);
    recorder.Clear();
    EXPECT_FALSE(recorder.Last().hit);
    FirstHitRecorder cheap(false);
    cheap.Record(si, mirror, {0, 0, 1});
    EXPECT_EQ(cheap.Last().albedo, SampledSpectrum(0));
}

}  // namespace
}  // namespace lacquer
