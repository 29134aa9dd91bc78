// Derivatives against differences: what the tests of reverse mode share.
#pragma once

#include <cmath>
#include <functional>
#include <span>
#include <vector>

#include "estimate/random.h"

namespace lacquer::estimate {

/// Derivative of f along a line at 0 by five points: error of order step^4, and rounding of f over step.
inline double DifferenceAlong(const std::function<double(double)>& f, double step) {
    return (8 * (f(step) - f(-step)) - (f(2 * step) - f(-2 * step))) / (12 * step);
}

/// Numbers uniform in [low, high].
inline std::vector<double> RandomNumbers(size_t count, uint64_t seed, double low, double high) {
    Random random(seed, 17);
    std::vector<double> values(count);
    for (double& v : values) v = low + (high - low) * random.Uniform();
    return values;
}

inline double Dot(std::span<const double> a, std::span<const double> b) {
    double sum = 0;
    for (size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
    return sum;
}

/// Largest error of a gradient against differences along `directions` random directions, relative to the
/// length of the gradient: a direction of unit length has a derivative of that size over the square root of
/// the dimension, and the error is taken over this.
inline double GradientError(const std::function<double(std::span<const double>)>& f,
                            std::span<const double> at, std::span<const double> gradient, double step,
                            int directions) {
    double worst = 0;
    for (int d = 0; d < directions; ++d) {
        const auto direction = RandomNumbers(at.size(), 1000 + uint64_t(d), -1, 1);
        const double typical = std::sqrt(Dot(gradient, gradient) / 3);
        const double difference = DifferenceAlong(
            [&](double t) {
                std::vector<double> x(at.begin(), at.end());
                for (size_t i = 0; i < x.size(); ++i) x[i] += t * direction[i];
                return f(x);
            },
            step);
        worst = std::max(worst, std::abs(Dot(gradient, direction) - difference) / typical);
    }
    return worst;
}

}  // namespace lacquer::estimate
