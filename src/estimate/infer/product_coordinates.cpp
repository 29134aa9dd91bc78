#include "estimate/infer/product_coordinates.h"

#include <algorithm>
#include <cmath>

#include "pbrt/core/check.h"

namespace lacquer::estimate {

ProductCoordinates::ProductCoordinates(const ParameterSpace& space) : space_(space) {
    for (size_t i = 0; i < space.Size(); ++i) {
        const auto scale = space.Find(space[i].productWith);
        if (!scale) continue;
        LACQUER_CHECK(space[*scale].productWith.empty() && space[*scale].prior.low >= 0 &&
                      space[i].prior.low >= 0);
        factors_.push_back({Eigen::Index(i), Eigen::Index(*scale), space[i].prior.low, space[i].prior.high});
    }
}

bool ProductCoordinates::Values(const Vector& t, Vector* x) const {
    // Scales are no factors, so their coordinates are logits.
    *x = space_.ToNatural(t);
    bool isInside = true;
    for (const Factor& f : factors_) {
        double& value = (*x)[f.index];
        value = std::exp(t[f.index]) / (*x)[f.scale];
        isInside &= value > f.low && value < f.high;
    }
    return isInside;
}

bool ProductCoordinates::Logits(const Vector& t, Vector* y, double* logDeterminant) const {
    Vector x;
    if (!Values(t, &x)) return false;
    *y = t;
    *logDeterminant = 0;
    // With v the factor and t = log(v s): dv/dt = v, and its logit has dy/dv = (high - low) / ((v - low)(high
    // - v)).
    for (const Factor& f : factors_) {
        const double v = x[f.index];
        (*y)[f.index] = std::log((v - f.low) / (f.high - v));
        *logDeterminant += std::log(v * (f.high - f.low) / ((v - f.low) * (f.high - v)));
    }
    return true;
}

// With s the scale: dv/dt = v, and dv/ds = -v / s at fixed t.
Vector ProductCoordinates::GradientByCoordinates(const Vector& y, const Vector& byLogits) const {
    const Vector x = space_.ToNatural(y), slopes = space_.Slopes(y);  // dx/dy
    Vector gradient = byLogits;
    for (const Factor& f : factors_) {
        const double v = x[f.index];
        // d/dv of the whole: by the logit, and by the logarithm of v dy/dv.
        const double byValue = (byLogits[f.index] * (f.high - f.low) / ((v - f.low) * (f.high - v))) + 1 / v -
                               1 / (v - f.low) + 1 / (f.high - v);
        gradient[f.index] = v * byValue;
        gradient[f.scale] -= v / x[f.scale] * slopes[f.scale] * byValue;
    }
    return gradient;
}

Vector ProductCoordinates::GradientByLogits(const Vector& y, const Vector& byCoordinates) const {
    const Vector x = space_.ToNatural(y), slopes = space_.Slopes(y);
    Vector gradient = byCoordinates;
    for (const Factor& f : factors_) {
        gradient[f.index] = byCoordinates[f.index] * slopes[f.index] / x[f.index];
        gradient[f.scale] += byCoordinates[f.index] * slopes[f.scale] / x[f.scale];
    }
    return gradient;
}

Matrix ProductCoordinates::FromLogits(const Matrix& y) const {
    Matrix t = y;
    for (Eigen::Index k = 0; k < y.cols(); ++k) {
        const Vector x = space_.ToNatural(y.col(k));
        for (const Factor& f : factors_) t(f.index, k) = std::log(x[f.index] * x[f.scale]);
    }
    return t;
}

Matrix ProductCoordinates::ToLogits(const Matrix& t) const {
    Matrix y = t;
    for (Eigen::Index k = 0; k < t.cols(); ++k) {
        Vector x;
        Values(t.col(k), &x);
        for (const Factor& f : factors_) {
            const double margin = ParameterSpace::kMargin * (f.high - f.low);
            const double v = std::clamp(x[f.index], f.low + margin, f.high - margin);
            y(f.index, k) = std::log((v - f.low) / (f.high - v));
        }
    }
    return y;
}

}  // namespace lacquer::estimate
