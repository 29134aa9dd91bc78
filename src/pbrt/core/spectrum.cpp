#include "pbrt/core/spectrum.h"

#include <algorithm>

namespace lacquer {

SampledSpectrum Spectrum::Sample(const SampledWavelengths& lambda) const {
    SampledSpectrum s;
    for (int i = 0; i < kNumWavelengths; ++i) s.Set(i, Evaluate(lambda[i]));
    return s;
}

PiecewiseLinearSpectrum::PiecewiseLinearSpectrum(std::vector<float> lambda, std::vector<float> values)
    : lambda_(std::move(lambda)), values_(std::move(values)) {
    for (float v : values_) max_ = std::max(max_, v);
    constexpr size_t kFewest = 16;  // of fewer a search takes no longer, and scenes have many of them
    if (lambda_.size() < kFewest) return;
    cells_.reserve(size_t(kLambdaMax - kLambdaMin) + 1);
    const auto evaluate = [this](float nm) { return Between(0, lambda_.size(), nm); };
    for (float nm = kLambdaMin; nm <= kLambdaMax; ++nm) {
        const int interval =
            FindInterval(int(lambda_.size()), [&](int k) { return lambda_[size_t(k)] <= nm; });
        const bool isWithin = lambda_.front() <= nm && nm + 1 <= lambda_.back();
        const float value = evaluate(nm);
        cells_.push_back({value, evaluate(nm + 1) - value, uint32_t(interval),
                          isWithin && lambda_[size_t(interval) + 1] >= nm + 1});
    }
}

PiecewiseLinearSpectrum PiecewiseLinearSpectrum::Extended(std::vector<float> lambda,
                                                          std::vector<float> values) {
    if (lambda.front() > kLambdaMin - 1) {
        lambda.insert(lambda.begin(), kLambdaMin - 1);
        values.insert(values.begin(), values.front());
    }
    if (lambda.back() < kLambdaMax + 1) {
        lambda.push_back(kLambdaMax + 1);
        values.push_back(values.back());
    }
    return PiecewiseLinearSpectrum(std::move(lambda), std::move(values));
}

float PiecewiseLinearSpectrum::Between(size_t first, size_t end, float lambda) const {
    if (lambda_.empty() || lambda < lambda_.front() || lambda > lambda_.back()) return 0;
    if (lambda_.size() == 1) return values_[0];
    const size_t i =
        first +
        size_t(FindInterval(int(end - first), [&](int k) { return lambda_[first + size_t(k)] <= lambda; }));
    const float t = (lambda - lambda_[i]) / (lambda_[i + 1] - lambda_[i]);
    return Lerp(t, values_[i], values_[i + 1]);
}

void PiecewiseLinearSpectrum::Scale(float s) {
    for (float& v : values_) v *= s;
    for (Cell& cell : cells_) {
        cell.value *= s;
        cell.slope *= s;
    }
    max_ *= s;
}

float BlackbodyRadiance(float lambda, float kelvin) {
    if (kelvin <= 0) return 0;
    constexpr double c = 299792458, h = 6.62606957e-34, kB = 1.3806488e-23;
    const double metres = double(lambda) * 1e-9, fifth = metres * metres * metres * metres * metres;
    return float((2 * h * c * c) / (fifth * (std::exp((h * c) / (metres * kB * double(kelvin))) - 1)));
}

BlackbodySpectrum::BlackbodySpectrum(float kelvin) : kelvin_(kelvin) {
    // Wien's displacement law gives the wavelength of the maximum [m].
    const float peak = 2.8977721e-3f / kelvin;
    normalization_ = 1 / BlackbodyRadiance(peak * 1e9f, kelvin);
}

float BlackbodySpectrum::Evaluate(float lambda) const {
    return BlackbodyRadiance(lambda, kelvin_) * normalization_;
}

DenselySampledSpectrum::DenselySampledSpectrum(const std::function<float(float)>& f) : values_(kCount) {
    for (int i = 0; i < kCount; ++i) values_[size_t(i)] = f(float(kFirst + i));
}

float DenselySampledSpectrum::MaxValue() const { return *std::max_element(values_.begin(), values_.end()); }

void DenselySampledSpectrum::Scale(float s) {
    for (float& v : values_) v *= s;
}

float InnerProduct(const Spectrum& a, const Spectrum& b) {
    double sum = 0;
    const int last = int(kLambdaMax);
    for (int nm = int(kLambdaMin); nm <= last; nm += kNumWavelengths) {
        SampledSpectrum lambda;
        for (int i = 0; i < kNumWavelengths; ++i) lambda.Set(i, float(std::min(nm + i, last)));
        const SampledWavelengths eight = SampledWavelengths::At(lambda);
        const SampledSpectrum x = a.Sample(eight), y = b.Sample(eight);
        for (int i = 0; i < std::min(kNumWavelengths, last + 1 - nm); ++i) sum += double(x[i]) * double(y[i]);
    }
    return float(sum);
}

}  // namespace lacquer
