// Auxiliary outputs about the samples of a pixel:
//   variance         of the luminance of one sample
//   samples          their number
//   sensorvariance   of the sensor's response, and that over the squared mean; of the gbuffer film
#include "pbrt/film/aov_output.h"

namespace lacquer {
namespace {

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
