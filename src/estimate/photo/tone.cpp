#include "estimate/photo/tone.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "estimate/powers.h"

namespace lacquer::estimate {
namespace {

// The curve of sRGB: straight up to kSrgbJoint, then a power.
constexpr double kSrgbJoint = 0.0031308, kSrgbSlope = 12.92, kSrgbScale = 1.055, kSrgbOffset = 0.055;

double ExponentOf(ToneCurve curve) { return curve == ToneCurve::SRGB ? 1 / 2.4 : 1 / 2.2; }

}  // namespace

void ApplyTone(ToneCurve curve, const PlanarImage& linear, PlanarImage* toned) {
    if (toned->values.size() != linear.values.size()) *toned = PlanarImage(linear.size);
    const std::vector<double>& in = linear.values;
    std::vector<double>& out = toned->values;
    if (curve == ToneCurve::Linear) {
        for (size_t i = 0; i < in.size(); ++i) out[i] = std::clamp(in[i], 0., 1.);
        return;
    }
    ForEachPower(
        in.size(), ExponentOf(curve), [&](size_t i) { return std::clamp(in[i], kDarkest, 1.); },
        [&](size_t i, double power) {
            const double v = std::max(in[i], 0.);
            if (curve == ToneCurve::SRGB)
                out[i] = v < kSrgbJoint ? kSrgbSlope * v : kSrgbScale * power - kSrgbOffset;
            else
                out[i] = v < kDarkest ? power / kDarkest * v : power;
        });
}

void ToneAdjoint(ToneCurve curve, const PlanarImage& linear, const PlanarImage& toned, PlanarImage* by) {
    const double exponent = ExponentOf(curve);
    for (size_t i = 0; i < linear.values.size(); ++i) {
        const double v = linear.values[i], t = toned.values[i];
        double slope = 1;
        if (curve == ToneCurve::SRGB)
            slope = v < kSrgbJoint ? kSrgbSlope : exponent * (t + kSrgbOffset) / v;
        else if (curve == ToneCurve::Gamma22)
            slope = v < kDarkest ? (v > 0 ? t / v : 0) : exponent * t / v;
        by->values[i] *= v > 0 && v < 1 ? slope : 0;
    }
}

void AverageClamped(const PlanarImage& fine, int count, PlanarImage* means) {
    const int size = fine.size / count;
    if (means->size != size) *means = PlanarImage(size);
    std::ranges::fill(means->values, 0.);
    const double weight = 1. / (count * count);
    for (size_t c = 0; c < 3; ++c)
        for (int y = 0; y < size * count; ++y) {
            const double* in = fine.Channel(c).data() + size_t(y) * size_t(fine.size);
            double* out = means->Channel(c).data() + size_t(y / count) * size_t(size);
            for (int x = 0; x < size; ++x)
                for (int k = 0; k < count; ++k) out[x] += weight * std::clamp(*in++, 0., 1.);
        }
}

PlanarImage AverageAdjoint(const PlanarImage& fine, int count, const PlanarImage& byMeans) {
    PlanarImage by(fine.size);
    const double weight = 1. / (count * count);
    for (size_t c = 0; c < 3; ++c)
        for (int y = 0; y < byMeans.size * count; ++y)
            for (int x = 0; x < byMeans.size * count; ++x) {
                const size_t i = size_t(y) * size_t(fine.size) + size_t(x);
                const double v = fine.Channel(c)[i];
                if (v > 0 && v < 1)
                    by.Channel(c)[i] =
                        weight *
                        byMeans.Channel(c)[size_t(y / count) * size_t(byMeans.size) + size_t(x / count)];
            }
    return by;
}

void RoundToBytes(PlanarImage* toned) {
    for (double& v : toned->values) v = std::floor(255 * v + 0.5) / 255;
}

double ClippedShare(const PlanarImage& linear) {
    const auto clipped =
        std::count_if(linear.values.begin(), linear.values.end(), [](double v) { return v >= 1; });
    return double(clipped) / double(linear.values.size());
}

}  // namespace lacquer::estimate
