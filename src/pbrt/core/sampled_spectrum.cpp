#include "pbrt/core/sampled_spectrum.h"

#include "pbrt/core/lane_functions.h"

namespace lacquer {

// Integral of the sech^2 density from 360 nm: (tanh(k (lambda - 538)) + tanh(k 178)) / (tanh(k 292) + tanh(k
// 178)).
float SampleVisibleWavelength(float u) {
    return 538 - 138.888889f * std::atanh(0.85691062f - 1.82750197f * u);
}

float PdfVisibleWavelength(float lambda) {
    if (lambda < kLambdaMin || lambda > kLambdaMax) return 0;
    return 0.0039398042f / Sqr(std::cosh(0.0072f * (lambda - 538)));
}

float InvertVisibleWavelength(float lambda) {
    return (0.85691062f - std::tanh((538 - lambda) / 138.888889f)) / 1.82750197f;
}

SampledWavelengths SampledWavelengths::SampleVisible(float u) {
    const LaneFloats shifted = u + MakeLanes<LaneFloats>([](int i) { return float(i) / kNumWavelengths; });
    const LaneFloats ui = shifted >= 1.f ? shifted - 1.f : shifted;
    // With t = tanh(k (538 - lambda)) the density is proportional to 1 - t^2: no cosh is needed.
    const LaneFloats t = 0.85691062f - 1.82750197f * ui;
    SampledWavelengths s;
    s.lambda_ = 538.f - 138.888889f * 0.5f * LogOfLanes((1.f + t) / (1.f - t));
    s.pdf_ = 0.0039398042f * (1.f - t * t);
    return s;
}

SampledWavelengths SampledWavelengths::SampleUniform(float u, float low, float high) {
    SampledWavelengths s;
    for (int i = 0; i < kNumWavelengths; ++i) {
        float ui = u + float(i) / kNumWavelengths;
        if (ui >= 1) ui -= 1;
        s.lambda_.Set(i, lacquer::Lerp(ui, low, high));
        s.pdf_.Set(i, 1 / (high - low));
    }
    return s;
}

void SampledWavelengths::TerminateSecondary() {
    if (SecondaryTerminated()) return;
    lambda_ = SampledSpectrum(lambda_[0]);
    for (int i = 1; i < kNumWavelengths; ++i) pdf_.Set(i, 0);
    pdf_.Set(0, pdf_[0] / kNumWavelengths);
}

}  // namespace lacquer
