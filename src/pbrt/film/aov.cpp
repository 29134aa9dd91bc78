#include "pbrt/film/aov.h"

#include <algorithm>

namespace lacquer {

namespace {

/// Channel names of one output.
std::vector<std::string> ChannelNames(const std::string& name) {
    if (name == "albedo") return {"Albedo.R", "Albedo.G", "Albedo.B"};
    if (name == "normal") return {"N.X", "N.Y", "N.Z"};
    if (name == "shadingnormal") return {"Ns.X", "Ns.Y", "Ns.Z"};
    if (name == "position") return {"P.X", "P.Y", "P.Z"};
    if (name == "depth") return {"Z"};
    if (name == "uv") return {"u", "v"};
    if (name == "variance") return {"Variance.Y"};
    return {"samples"};
}

/// Reflectance for one direction from 16 samples of the BxDF at fixed points (the first of a Hammersley set).
SampledSpectrum Albedo(const BxDF& bxdf, Vec3 wo) {
    constexpr int kSamples = 16;
    Rng rng(1);
    SampledSpectrum sum(0);
    for (int i = 0; i < kSamples; ++i) {
        const float x = (float(i) + 0.5f) / kSamples;
        float y = 0, digit = 0.5f;
        for (int bits = i; bits; bits >>= 1, digit /= 2) y += digit * float(bits & 1);
        const BxDFContext context{TransportMode::Radiance, Lobes::BothSides, &rng};
        const auto sample = bxdf.Sample(wo, {std::fmod(x * 7 + 0.03125f, 1.f), {x, y + 0.03f}}, context);
        if (sample) sum += sample->weight;
    }
    return sum / float(kSamples);
}

void AddTo(double* sum, Vec3 v) {
    for (int i = 0; i < 3; ++i) sum[i] += double(v[i]);
}

void Append(std::vector<float>* out, const double* v, int count, double divisor) {
    for (int i = 0; i < count; ++i) out->push_back(divisor > 0 ? float(v[i] / divisor) : 0.f);
}

double Length3(const double* v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

}  // namespace

void FirstHitRecorder::Record(const SurfaceInteraction& si, const BxDF& bxdf, Vec3 woLocal) {
    last_.hit = true;
    last_.p = si.p;
    last_.n = FaceForward(si.n, si.wo);
    last_.ns = FaceForward(si.shading.n, si.wo);
    last_.uv = si.uv;
    if (wantAlbedo_) last_.albedo = Albedo(bxdf, woLocal);
}

const std::vector<std::string>& AovBuffer::Names() {
    static const std::vector<std::string> names{"albedo", "normal", "shadingnormal", "position",
                                                "depth",  "uv",     "variance",      "samples"};
    return names;
}

AovBuffer::AovBuffer(const std::vector<std::string>& names, const Bounds2i& pixelBounds,
                     const ColorSpace& space, const Transform& worldFromRender,
                     const Transform& cameraFromRender)
    : names_(names),
      bounds_(pixelBounds),
      space_(&space),
      worldFromRender_(worldFromRender),
      cameraFromRender_(cameraFromRender),
      pixels_(size_t(pixelBounds.Area())) {}

bool AovBuffer::Wants(const std::string& name) const {
    return std::find(names_.begin(), names_.end(), name) != names_.end();
}

bool AovBuffer::WantsFirstHit() const {
    return std::any_of(names_.begin(), names_.end(),
                       [](const std::string& name) { return name != "variance" && name != "samples"; });
}

void AovBuffer::Add(Int2 p, const FirstHit& hit, SampledSpectrum L, const SampledWavelengths& lambda) {
    const Int2 q = p - bounds_.min;
    Pixel& pixel = pixels_[size_t(q.y) * size_t(bounds_.Width()) + size_t(q.x)];
    pixel.samples += 1;
    // Welford's running mean and sum of squared deviations.
    const double y = double(SafeDivide(L * CieY().Sample(lambda), lambda.Pdf()).Average());
    const double delta = y - pixel.luminanceMean;
    pixel.luminanceMean += delta / pixel.samples;
    pixel.luminanceM2 += delta * (y - pixel.luminanceMean);
    if (!hit.hit) return;
    pixel.hits += 1;
    AddTo(pixel.n, worldFromRender_.Normal(hit.n));
    AddTo(pixel.ns, worldFromRender_.Normal(hit.ns));
    AddTo(pixel.p, worldFromRender_.Point(hit.p));
    pixel.z += double(cameraFromRender_.Point(hit.p).z);
    pixel.uv[0] += double(hit.uv.x);
    pixel.uv[1] += double(hit.uv.y);
    // The albedo as a colour: what a white light of unit luminance makes of it.
    const SampledSpectrum lit =
        SafeDivide(hit.albedo * space_->Illuminant().Sample(lambda), lambda.Pdf()) / kCieYIntegral;
    const XYZ xyz((lit * CieX().Sample(lambda)).Average(), (lit * CieY().Sample(lambda)).Average(),
                  (lit * CieZ().Sample(lambda)).Average());
    AddTo(pixel.albedo, space_->ToRGB(xyz));
}

std::vector<float> AovBuffer::Channels(const Pixel& pixel) const {
    std::vector<float> values;
    for (const std::string& name : names_) {
        if (name == "albedo") Append(&values, pixel.albedo, 3, pixel.samples);
        if (name == "normal") Append(&values, pixel.n, 3, Length3(pixel.n));
        if (name == "shadingnormal") Append(&values, pixel.ns, 3, Length3(pixel.ns));
        if (name == "position") Append(&values, pixel.p, 3, pixel.hits);
        if (name == "depth") Append(&values, &pixel.z, 1, pixel.hits);
        if (name == "uv") Append(&values, pixel.uv, 2, pixel.hits);
        if (name == "variance") Append(&values, &pixel.luminanceM2, 1, pixel.samples - 1);
        if (name == "samples") values.push_back(float(pixel.samples));
    }
    return values;
}

std::unique_ptr<Image> AovBuffer::AppendTo(const Image& rgb) const {
    std::vector<std::string> channels = rgb.Channels();
    for (const std::string& name : names_)
        for (const std::string& channel : ChannelNames(name)) channels.push_back(channel);
    auto image = std::make_unique<Image>(rgb.Resolution(), channels);
    image->dataWindow = rgb.dataWindow;
    image->fullResolution = rgb.fullResolution;
    image->metadata = rgb.metadata;
    image->SetColorSpace(rgb.ColorSpace());
    const size_t colors = size_t(rgb.NumChannels());
    float* out = image->Pixels().data();
    for (size_t i = 0; i < pixels_.size(); ++i) {
        out = std::copy_n(rgb.Pixels().data() + i * colors, colors, out);
        const std::vector<float> extra = Channels(pixels_[i]);
        out = std::copy(extra.begin(), extra.end(), out);
    }
    return image;
}

}  // namespace lacquer
