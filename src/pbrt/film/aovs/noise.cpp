// Auxiliary outputs about the samples of a pixel:
//   variance         of the luminance of one sample
//   samples          their number
//   sensorvariance   of the sensor's response, and that over the squared mean; of the gbuffer film
#include "pbrt/film/aov_output.h"

namespace lacquer {
namespace {

void SetSquares(double x, double* terms) {
    terms[0] = x;
    terms[1] = x * x;
}

/// Unbiased, from the sums of n values and of their squares. What the sums do not resolve is 0: the variance
/// of values that are equal, say.
double Variance(const double* sums, double n) {
    constexpr double kResolution = 0x1p-34;
    const double deviations = sums[1] - sums[0] * sums[0] / n;
    return n > 1 && deviations > kResolution * sums[1] ? deviations / (n - 1) : 0.0;
}

void AddLuminanceVariance(const AovSample& s, double* terms) {
    SetSquares(double(SafeDivide(s.L * CieY().Sample(s.lambda), s.lambda.Pdf()).Average()), terms);
}

void DevelopLuminanceVariance(const ColorSpace&, const AovCounts& counts, const double* sums, float* out) {
    out[0] = float(Variance(sums, counts.samples));
}

void AddSensorVariance(const AovSample& s, double* terms) {
    for (int c = 0; c < 3; ++c) SetSquares(double(s.response[c]), terms + 2 * c);
}

void DevelopSensorVariance(const ColorSpace&, const AovCounts& counts, const double* sums, float* out) {
    for (int c = 0; c < 3; ++c) {
        const double variance = Variance(sums + 2 * c, counts.hits);
        const double mean = counts.hits > 0 ? sums[2 * c] / counts.hits : 0;
        out[c] = float(variance);
        out[c + 3] = mean == 0 ? 0.f : float(variance / Sqr(mean));
    }
}

void AddNothing(const AovSample&, double*) {}

void DevelopCount(const ColorSpace&, const AovCounts& counts, const double*, float* out) {
    out[0] = float(counts.samples);
}

AovOutput LuminanceVariance() {
    return {.channels = {"Variance.Y"},
            .numSums = 2,
            .needsFloats = true,
            .add = AddLuminanceVariance,
            .develop = DevelopLuminanceVariance};
}

AovOutput SampleCount() {
    return {.channels = {"samples"}, .needsFloats = true, .add = AddNothing, .develop = DevelopCount};
}

AovOutput SensorVariance() {
    return {.channels = {"Variance.R", "Variance.G", "Variance.B", "RelativeVariance.R", "RelativeVariance.G",
                         "RelativeVariance.B"},
            .numSums = 6,
            .needsFloats = true,
            .needs = {.any = true},
            .isInternal = true,
            .add = AddSensorVariance,
            .develop = DevelopSensorVariance};
}

}  // namespace

LACQUER_REGISTER(AovKind, "variance", LuminanceVariance);
LACQUER_REGISTER(AovKind, "samples", SampleCount);
LACQUER_REGISTER(AovKind, "sensorvariance", SensorVariance);

}  // namespace lacquer
