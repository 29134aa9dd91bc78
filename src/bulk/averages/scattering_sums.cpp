#include "bulk/averages/scattering_sums.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <type_traits>

#include "pbrt/core/check.h"

namespace lacquer::bulk {

std::vector<double> ClenshawCurtisWeights(int n) {
    LACQUER_CHECK(n >= 2 && n % 2 == 0);
    std::vector<double> weights;
    for (int j = 0; j <= n; ++j) {
        double weight = 1;
        for (int k = 1; k <= n / 2; ++k)
            weight -= (2 * k == n ? 1. : 2.) / (4. * k * k - 1) * std::cos(2 * k * j * std::numbers::pi / n);
        weights.push_back(weight * (j == 0 || j == n ? 1. : 2.) / n);
    }
    return weights;
}

ScatteringSums::ScatteringSums(int numAngles)
    : weights_(ClenshawCurtisWeights(numAngles - 1)), groups_(size_t(kNumGroups)) {
    for (Sums& group : groups_) group.angles.resize(size_t(numAngles));
}

void ScatteringSums::Sums::Add(const Sums& other, double sign) {
    count += sign * other.count;
    numParticles += sign * other.numParticles;
    extinction += sign * other.extinction;
    absorption += sign * other.absorption;
    scattering += sign * other.scattering;
    for (size_t i = 0; i < angles.size(); ++i) {
        for (size_t k = 0; k < 6; ++k) angles[i].mueller[k] += sign * other.angles[i].mueller[k];
        for (size_t k = 0; k < 4; ++k) angles[i].amplitude[k] += sign * other.angles[i].amplitude[k];
        angles[i].amplitudeSquares += sign * other.angles[i].amplitudeSquares;
    }
}

void ScatteringSums::Add(const RealizationScattering& realization) {
    Sums& group = groups_[size_t(numRealizations_++ % kNumGroups)];
    LACQUER_CHECK(realization.angles.size() == group.angles.size());
    group.count += 1;
    group.numParticles += realization.numParticles;
    group.extinction += realization.extinction;
    group.absorption += realization.absorption;
    group.scattering += realization.scattering;
    for (size_t i = 0; i < group.angles.size(); ++i) {
        const AzimuthalMeans& means = realization.angles[i];
        Angle& angle = group.angles[i];
        const double elements[] = {means.s11, means.s12, means.s22, means.s33, means.s34, means.s44};
        for (size_t k = 0; k < 6; ++k) angle.mueller[k] += elements[k];
        for (int k = 0; k < 4; ++k) {
            const Complex f = means.amplitude(k / 2, k % 2);
            angle.amplitude[size_t(k)] += f;
            angle.amplitudeSquares += std::norm(f);
        }
    }
}

// Of each group its five sums, and then its angles.
size_t ScatteringSums::StateSize() const {
    static_assert(sizeof(Angle) == kNumbersOfAngle * sizeof(double) && std::is_trivially_copyable_v<Angle>);
    return groups_.size() * (5 + kNumbersOfAngle * weights_.size());
}

std::vector<double> ScatteringSums::State() const {
    std::vector<double> state(StateSize());
    double* at = state.data();
    for (const Sums& group : groups_) {
        for (const double sum :
             {group.count, group.numParticles, group.extinction, group.absorption, group.scattering})
            *at++ = sum;
        std::memcpy(at, group.angles.data(), group.angles.size() * sizeof(Angle));
        at += kNumbersOfAngle * group.angles.size();
    }
    return state;
}

void ScatteringSums::SetState(std::span<const double> state) {
    LACQUER_CHECK(state.size() == StateSize());
    const double* at = state.data();
    numRealizations_ = 0;
    for (Sums& group : groups_) {
        for (double* sum :
             {&group.count, &group.numParticles, &group.extinction, &group.absorption, &group.scattering})
            *sum = *at++;
        std::memcpy(static_cast<void*>(group.angles.data()), at, group.angles.size() * sizeof(Angle));
        at += kNumbersOfAngle * group.angles.size();
        numRealizations_ += int(group.count);
    }
}

double ScatteringSums::MeanParticles() const {
    double sum = 0;
    for (const Sums& group : groups_) sum += group.numParticles;
    return sum / numRealizations_;
}

std::vector<double> ScatteringSums::Evaluate(const Sums& sums, AverageMode mode) const {
    if (!(sums.numParticles > 0)) return std::vector<double>(4 + sums.angles.size(), 0.);
    std::vector<double> values{sums.extinction / sums.numParticles, sums.absorption / sums.numParticles, 0,
                               0};
    double integral = 0, cosines = 0;
    const double n = double(sums.angles.size() - 1);
    for (size_t i = 0; i < sums.angles.size(); ++i) {
        const Angle& angle = sums.angles[i];
        double intensity = angle.mueller[0];
        if (mode != AverageMode::Aggregate) {
            // Half of the sum of |<F_ij>|^2, from pairs of different realisations, times their number.
            double square = -angle.amplitudeSquares;
            for (const Complex& f : angle.amplitude) square += std::norm(f);
            const double coherent = 0.5 * square / (sums.count - 1);
            intensity = mode == AverageMode::Medium ? intensity - coherent : coherent;
        }
        intensity /= sums.numParticles;
        values.push_back(intensity);
        integral += 2 * std::numbers::pi * weights_[i] * intensity;
        cosines +=
            2 * std::numbers::pi * weights_[i] * intensity * std::cos(double(i) * std::numbers::pi / n);
    }
    // The mean intensity's integral is known exactly.
    values[2] = mode == AverageMode::Aggregate ? sums.scattering / sums.numParticles : integral;
    values[3] = integral != 0 ? cosines / integral : 0;
    return values;
}

ScatteringAverage ScatteringSums::Average(AverageMode mode) const {
    LACQUER_CHECK(numRealizations_ >= (mode == AverageMode::Aggregate ? 1 : 2));
    Sums all;
    all.angles.resize(weights_.size());
    for (const Sums& group : groups_) all.Add(group, 1);
    const std::vector<double> values = Evaluate(all, mode);
    // Without each group in turn. Fewer realisations than groups: as many groups as there are.
    std::vector<double> squares(values.size(), 0.), means(values.size(), 0.);
    const int numGroups = std::min(kNumGroups, numRealizations_);
    if (numRealizations_ >= 3) {
        for (int g = 0; g < numGroups; ++g) {
            Sums rest = all;
            rest.Add(groups_[size_t(g)], -1);
            const std::vector<double> without = Evaluate(rest, mode);
            for (size_t i = 0; i < values.size(); ++i) {
                const double change = without[i] - values[i];
                means[i] += change / numGroups;
                squares[i] += change * change / numGroups;
            }
        }
    }
    const auto error = [&](size_t i) {
        return std::sqrt(std::max(0., squares[i] - means[i] * means[i]) * (numGroups - 1));
    };
    ScatteringAverage average;
    ScatteringAverage::Value* const named[] = {&average.extinction, &average.absorption, &average.scattering,
                                               &average.g};
    for (size_t i = 0; i < 4; ++i) *named[i] = {values[i], error(i)};
    for (size_t i = 0; i < weights_.size(); ++i) {
        average.intensity.push_back(values[4 + i]);
        average.intensityError.push_back(error(4 + i));
        if (mode != AverageMode::Chapter) {
            const std::array<double, 6>& m = all.angles[i].mueller;
            average.mueller.push_back({m[1] / m[0], m[2] / m[0], m[3] / m[0], m[4] / m[0], m[5] / m[0]});
        }
    }
    return average;
}

}  // namespace lacquer::bulk
