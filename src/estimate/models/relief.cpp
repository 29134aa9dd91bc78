#include "estimate/models/relief.h"

#include <cmath>

#include "estimate/models/phases.h"

namespace lacquer::estimate {

void SpectralRelief::Profile::Set(double newS) {
    s = newS;
    sum = sumOfDerivative = 0;
    for (size_t k = 0; k < values.size(); ++k) {
        const double f = frequencies[k] / s;
        values[k] = std::exp(-0.5 * f * f);
        if (frequencies[k] == 0) continue;
        sum += values[k] * values[k];
        sumOfDerivative += values[k] * values[k] * f * f / s;
    }
}

SpectralRelief::SpectralRelief(int size, double extent)
    : fft_(size), phases_(fft_.MakeHalf()), half_(fft_.MakeHalf()) {
    for (Profile* profile : {&x_, &y_}) {
        profile->values.resize(size_t(size));
        for (int row = 0; row < size; ++row)
            profile->frequencies.push_back(SignedFrequency(row, size) / extent);
    }
}

void SpectralRelief::SetPhases(uint64_t stream) { FillPhases(stream, &phases_); }

void SpectralRelief::Forward(double rms, double sx, double sy, std::span<double> height) {
    x_.Set(sx);
    y_.Set(sy);
    rms_ = rms;
    // Half of the sum of squares over all frequencies but (0, 0), whose profile is 1.
    norm_ = std::sqrt(0.5 * (x_.sum + y_.sum + x_.sum * y_.sum));
    // So narrow that no frequency of this grid has an amplitude: flat.
    const double scale = norm_ > 1e-150 ? rms / norm_ : 0;
    for (int row = 0; row < half_.rows; ++row) {
        const double a = scale * y_.values[size_t(row)];
        const size_t first = half_.Index(row, 0);
        for (int k = 0; k < half_.columns; ++k) {
            half_.re[first + size_t(k)] = a * x_.values[size_t(k)] * phases_.re[first + size_t(k)];
            half_.im[first + size_t(k)] = a * x_.values[size_t(k)] * phases_.im[first + size_t(k)];
        }
    }
    fft_.Inverse(&half_, height);
}

SpectralRelief::Adjoint SpectralRelief::Backward(std::span<const double> heightAdjoint) {
    if (norm_ <= 1e-150) return {};
    fft_.InverseAdjoint(heightAdjoint, &half_);
    double total = 0, byX = 0, byY = 0;
    for (int row = 0; row < half_.rows; ++row) {
        double rowTotal = 0, rowX = 0;
        for (int k = 0; k < half_.columns; ++k) {
            const size_t i = half_.Index(row, k);
            const double t =
                x_.values[size_t(k)] * (half_.re[i] * phases_.re[i] + half_.im[i] * phases_.im[i]);
            const double f = x_.frequencies[size_t(k)];
            rowTotal += t;
            rowX += t * f * f;
        }
        const double f = y_.frequencies[size_t(row)], value = y_.values[size_t(row)];
        total += value * rowTotal;
        byX += value * rowX;
        byY += value * f * f * rowTotal;
    }
    Adjoint adjoint;
    const double scale = rms_ / norm_, normSquared = norm_ * norm_;
    adjoint.rms = total / norm_;
    const auto of = [&](double by, const Profile& profile, const Profile& other) {
        // The norm changes as well: d norm^2 = (1 + other.sum) d(profile.sum) / 2.
        return scale * (by / (profile.s * profile.s * profile.s) -
                        total * 0.5 * profile.sumOfDerivative * (1 + other.sum) / normSquared);
    };
    adjoint.sx = of(byX, x_, y_);
    adjoint.sy = of(byY, y_, x_);
    return adjoint;
}

}  // namespace lacquer::estimate
