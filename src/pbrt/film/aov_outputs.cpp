#include "pbrt/film/aov_outputs.h"

#include <algorithm>

namespace lacquer {

namespace {

void AddTo(double* sum, Vec3 v) {
    for (int i = 0; i < 3; ++i) sum[i] += double(v[i]);
}

template <int n>
void MeanOverHits(const ColorSpace&, const AovCounts& counts, const double* sums, float* out) {
    for (int i = 0; i < n; ++i) out[i] = counts.hits > 0 ? float(sums[i] / counts.hits) : 0.f;
}

void Direction(const ColorSpace&, const AovCounts&, const double* sums, float* out) {
    const double length = std::sqrt(sums[0] * sums[0] + sums[1] * sums[1] + sums[2] * sums[2]);
    for (int i = 0; i < 3; ++i) out[i] = length > 0 ? float(sums[i] / length) : 0.f;
}

/// (X, Y, Z) of a spectrum from its values at the wavelengths of one sample.
XYZ EstimateXYZ(const SampledSpectrum& s, const SampledWavelengths& lambda) {
    const SampledSpectrum weighted = SafeDivide(s, lambda.Pdf()) / kCieYIntegral;
    return {(weighted * CieX().Sample(lambda)).Average(), (weighted * CieY().Sample(lambda)).Average(),
            (weighted * CieZ().Sample(lambda)).Average()};
}

// ---- Albedo ----

// Under the white of the colour space, and next to it the white itself at the same wavelengths: the quotient
// of the sums has no noise of the wavelengths where the albedo is grey, and little elsewhere. Its bias falls
// with the number of samples.
void AddAlbedo(const AovSample& s, const AovCounts&, double* sums) {
    const SampledSpectrum white = s.color.Illuminant().Sample(s.lambda);
    AddTo(sums, EstimateXYZ(s.hit.albedo * white, s.lambda));
    AddTo(sums + 3, EstimateXYZ(white, s.lambda));
}

void DevelopAlbedo(const ColorSpace& color, const AovCounts& counts, const double* sums, float* out) {
    const XYZ white = color.ToXYZ(RGB(1));
    const auto reflectance = [&](int i) { return sums[3 + i] > 0 ? sums[i] / sums[3 + i] : -1; };
    XYZ xyz(0);
    for (int i = 0; i < 3; ++i) {
        // A few samples may miss the wavelengths that Z sees: then the luminance has to do.
        const double r = reflectance(i) >= 0 ? reflectance(i) : std::max(0.0, reflectance(1));
        xyz[i] = white[i] * float(r);
    }
    const float coverage = counts.samples > 0 ? float(counts.hits / counts.samples) : 0.f;
    const RGB rgb = color.ToRGB(xyz) * coverage;
    for (int i = 0; i < 3; ++i) out[i] = std::clamp(rgb[i], 0.f, 1.f);
}

// ---- Geometry ----

void AddShadingNormal(const AovSample& s, const AovCounts&, double* sums) {
    AddTo(sums, Normalize(s.outputFromRender.Normal(s.hit.ns)));
}

void AddNormal(const AovSample& s, const AovCounts&, double* sums) {
    AddTo(sums, Normalize(s.outputFromRender.Normal(s.hit.n)));
}

void AddPosition(const AovSample& s, const AovCounts&, double* sums) {
    AddTo(sums, s.outputFromRender.Point(s.hit.p));
}

void AddDepth(const AovSample& s, const AovCounts&, double* sums) {
    sums[0] += double(s.cameraFromRender.Point(s.hit.p).z);
}

void AddUv(const AovSample& s, const AovCounts&, double* sums) {
    sums[0] += double(s.hit.uv.x);
    sums[1] += double(s.hit.uv.y);
}

void AddSlope(const AovSample& s, const AovCounts&, double* sums) {
    sums[0] += double(s.outputFromRender.Vector(s.hit.dpdx).z);
    sums[1] += double(s.outputFromRender.Vector(s.hit.dpdy).z);
}

void DevelopSlope(const ColorSpace& color, const AovCounts& counts, const double* sums, float* out) {
    MeanOverHits<2>(color, counts, sums, out);
    for (int i = 0; i < 2; ++i) out[i] = std::abs(out[i]);
}

// ---- Noise ----

/// Running mean and sum of squared deviations [Welford 1962]; x is the n-th value.
void AddToVariance(double x, double n, double* meanAndDeviations) {
    const double delta = x - meanAndDeviations[0];
    meanAndDeviations[0] += delta / n;
    meanAndDeviations[1] += delta * (x - meanAndDeviations[0]);
}

double Variance(const double* meanAndDeviations, double n) {
    return n > 1 ? meanAndDeviations[1] / (n - 1) : 0.0;
}

void AddLuminanceVariance(const AovSample& s, const AovCounts& counts, double* sums) {
    const double y = double(SafeDivide(s.L * CieY().Sample(s.lambda), s.lambda.Pdf()).Average());
    AddToVariance(y, counts.samples, sums);
}

void DevelopLuminanceVariance(const ColorSpace&, const AovCounts& counts, const double* sums, float* out) {
    out[0] = float(Variance(sums, counts.samples));
}

void AddSensorVariance(const AovSample& s, const AovCounts& counts, double* sums) {
    for (int c = 0; c < 3; ++c) AddToVariance(double(s.response[c]), counts.hits, sums + 2 * c);
}

void DevelopSensorVariance(const ColorSpace&, const AovCounts& counts, const double* sums, float* out) {
    for (int c = 0; c < 3; ++c) {
        const double mean = sums[2 * c], variance = Variance(sums + 2 * c, counts.hits);
        out[c] = float(variance);
        out[c + 3] = mean == 0 ? 0.f : float(variance / Sqr(mean));
    }
}

void AddNothing(const AovSample&, const AovCounts&, double*) {}

void DevelopCount(const ColorSpace&, const AovCounts& counts, const double*, float* out) {
    out[0] = float(counts.samples);
}

const std::vector<AovOutput>& Table() {
    constexpr bool kOfHits = true, kOfAll = false, kFloats = true, kHalf = false;
    static const std::vector<AovOutput> table{
        {"albedo", {"Albedo.R", "Albedo.G", "Albedo.B"}, 6, kOfHits, kHalf, AddAlbedo, DevelopAlbedo},
        {"normal", {"Ns.X", "Ns.Y", "Ns.Z"}, 3, kOfHits, kHalf, AddShadingNormal, Direction},
        {"ng", {"N.X", "N.Y", "N.Z"}, 3, kOfHits, kHalf, AddNormal, Direction},
        {"position", {"P.X", "P.Y", "P.Z"}, 3, kOfHits, kFloats, AddPosition, MeanOverHits<3>},
        {"depth", {"Z"}, 1, kOfHits, kFloats, AddDepth, MeanOverHits<1>},
        {"uv", {"u", "v"}, 2, kOfHits, kFloats, AddUv, MeanOverHits<2>},
        {"variance", {"Variance.Y"}, 2, kOfAll, kFloats, AddLuminanceVariance, DevelopLuminanceVariance},
        {"samples", {"samples"}, 0, kOfAll, kFloats, AddNothing, DevelopCount},
        {"slope", {"dzdx", "dzdy"}, 2, kOfHits, kFloats, AddSlope, DevelopSlope},
        {"sensorvariance",
         {"Variance.R", "Variance.G", "Variance.B", "RelativeVariance.R", "RelativeVariance.G",
          "RelativeVariance.B"},
         6,
         kOfHits,
         kFloats,
         AddSensorVariance,
         DevelopSensorVariance},
    };
    return table;
}

}  // namespace

std::span<const AovOutput> AovOutputs() { return Table(); }

const AovOutput* FindAovOutput(const std::string& name) {
    const auto it = std::find_if(Table().begin(), Table().end(),
                                 [&](const AovOutput& output) { return output.name == name; });
    return it == Table().end() ? nullptr : &*it;
}

}  // namespace lacquer
