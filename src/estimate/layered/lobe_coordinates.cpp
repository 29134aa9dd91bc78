#include "estimate/layered/lobe_coordinates.h"

#include <cmath>

#include "pbrt/core/check.h"

namespace lacquer::estimate {

LobeCoordinates::LobeCoordinates(const ParameterSpace& space, Eigen::Index count) {
    constexpr double kDecade = 10;
    for (size_t i = 0; i < size_t(count); ++i) {
        const Prior& prior = space[i].prior;
        const auto scale = space.Find(space[i].productWith);
        LACQUER_CHECK(!scale || (prior.low > 0 && space[*scale].prior.low > 0));
        isLogarithm_.push_back(scale || (prior.low > 0 && prior.high > kDecade * prior.low));
        scales_.push_back(scale ? Eigen::Index(*scale) : -1);
    }
}

Vector LobeCoordinates::FromNatural(const Vector& x) const {
    Vector p(Size());
    for (Eigen::Index i = 0; i < Size(); ++i) {
        const double value = scales_[size_t(i)] < 0 ? x[i] : x[i] * x[scales_[size_t(i)]];
        p[i] = isLogarithm_[size_t(i)] ? std::log(value) : value;
    }
    return p;
}

Vector LobeCoordinates::GradientByNatural(const Vector& x, const Vector& byCoordinates) const {
    Vector gradient = Vector::Zero(Size());
    for (Eigen::Index i = 0; i < Size(); ++i) {
        gradient[i] += isLogarithm_[size_t(i)] ? byCoordinates[i] / x[i] : byCoordinates[i];
        if (const Eigen::Index scale = scales_[size_t(i)]; scale >= 0)
            gradient[scale] += byCoordinates[i] / x[scale];
    }
    return gradient;
}

}  // namespace lacquer::estimate
