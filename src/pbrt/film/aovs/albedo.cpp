// Auxiliary output "albedo": what the first surface reflects and transmits of white light, 0 where there is
// none.
#include "pbrt/film/aov_output.h"
#include "pbrt/film/estimate_xyz.h"

namespace lacquer {
namespace {

// Under the white of the colour space, and next to it the white itself at the same wavelengths: the quotient
// of the sums has no noise of the wavelengths where the albedo is grey, and little elsewhere. Its bias falls
// with the number of samples.
void AddAlbedo(const AovSample& s, double* terms) {
    const SampledSpectrum white = s.color.Illuminant().Sample(s.lambda);
    SetTo(terms, EstimateXYZ(s.hit.albedo * white, s.lambda));
    SetTo(terms + 3, EstimateXYZ(white, s.lambda));
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

AovOutput Albedo() {
    return {.channels = {"Albedo.R", "Albedo.G", "Albedo.B"},
            .numSums = 6,
            .needs = {.any = true, .albedo = true},
            .add = AddAlbedo,
            .develop = DevelopAlbedo};
}

}  // namespace

LACQUER_REGISTER(AovKind, "albedo", Albedo);

}  // namespace lacquer
