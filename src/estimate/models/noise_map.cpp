#include "estimate/models/noise_map.h"

#include <algorithm>
#include <cmath>

#include "estimate/models/phases.h"

namespace lacquer::estimate {
namespace {

constexpr double kMean = 0.37, kSd = 0.16;

/// Amplitude at k cycles over 512 texels.
double AmplitudeAt(NoiseKind kind, double k) {
    if (kind == NoiseKind::BandLimited) return k >= 4 && k <= 64 ? 1 / k : 0;
    return std::pow(k, -1.6);
}

/// Sum of squared amplitudes over the frequencies of a map but 0, per frequency of one of 512 texels: the
/// variance.
double VarianceOf(NoiseKind kind, int texels) {
    const double step = double(NoiseMap::kTexels) / texels;
    double sum = 0;
    for (int row = 0; row < texels; ++row)
        for (int column = 0; column < texels; ++column) {
            const double k = step * std::hypot(SignedFrequency(row, texels), SignedFrequency(column, texels));
            if (k == 0) continue;
            const double a = AmplitudeAt(kind, k);
            sum += a * a;
        }
    return sum * step * step;
}

/// Scales and shifts to a mean and a standard deviation.
void Standardize(double mean, double sd, std::span<double> values) {
    double sum = 0, squares = 0;
    for (const double v : values) sum += v;
    const double oldMean = sum / double(values.size());
    for (const double v : values) squares += (v - oldMean) * (v - oldMean);
    const double oldSd = std::sqrt(squares / double(values.size())), scale = oldSd > 0 ? sd / oldSd : 0;
    for (double& v : values) v = mean + scale * (v - oldMean);
}

}  // namespace

NoiseMap::NoiseMap(NoiseKind kind, int texels)
    : kind_(kind),
      size_(texels),
      fft_(texels),
      half_(fft_.MakeHalf()),
      amplitudes_(half_.re.size()),
      table_(texels),
      sd_(kSd) {
    const double step = double(kTexels) / texels;
    for (int row = 0; row < half_.rows; ++row)
        for (int column = 0; column < half_.columns; ++column) {
            const double k = step * std::hypot(SignedFrequency(row, texels), column);
            amplitudes_[half_.Index(row, column)] = k == 0 ? 0 : AmplitudeAt(kind, k);
        }
    if (texels != kTexels) sd_ *= std::sqrt(VarianceOf(kind, texels) / VarianceOf(kind, kTexels));
}

void NoiseMap::SetSeed(uint64_t stream) {
    FillPhases(stream, &half_);
    for (size_t i = 0; i < amplitudes_.size(); ++i) {
        half_.re[i] *= amplitudes_[i];
        half_.im[i] *= amplitudes_[i];
    }
    fft_.Inverse(&half_, table_.values);
    if (kind_ == NoiseKind::Ridged) {
        Standardize(0, 1, table_.values);
        for (double& v : table_.values) v = 1 - std::abs(v);
    }
    Standardize(kMean, sd_, table_.values);
    for (double& v : table_.values) v = std::clamp(v, 0., 1.);
}

}  // namespace lacquer::estimate
