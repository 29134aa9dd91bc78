#include "estimate/infer/product_target.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pbrt/core/check.h"

namespace lacquer::estimate {

ProductTarget::ProductTarget(const ParameterSpace& space, const Target& target)
    : space_(space), target_(target) {
    for (size_t i = 0; i < space.Size(); ++i) {
        const auto scale = space.Find(space[i].productWith);
        if (!scale) continue;
        LACQUER_CHECK(space[*scale].productWith.empty() && space[*scale].prior.low >= 0 &&
                      space[i].prior.low >= 0);
        factors_.push_back({Eigen::Index(i), Eigen::Index(*scale), space[i].prior.low, space[i].prior.high});
    }
}

bool ProductTarget::Values(const Vector& t, Vector* x) const {
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

// With v the factor, s its scale and t = log(v s): dv/dt = v, and dv/ds = -v / s at fixed t. The logit of v
// has the slope dy/dv = (high - low) / ((v - low)(high - v)), so the density of t is that of y times v dy/dv.
double ProductTarget::LogDensity(const Vector& t, Vector* gradient) const {
    Vector x;
    if (!Values(t, &x)) return -std::numeric_limits<double>::infinity();
    Vector y = t;
    for (const Factor& f : factors_) y[f.index] = std::log((x[f.index] - f.low) / (f.high - x[f.index]));
    double value = target_.LogDensity(y, gradient);
    const Vector slopes = space_.Slopes(y);  // dx/dy
    const Vector byLogits = gradient ? *gradient : Vector();
    for (const Factor& f : factors_) {
        const double v = x[f.index], slope = (f.high - f.low) / ((v - f.low) * (f.high - v));
        value += std::log(v * slope);
        if (!gradient) continue;
        // d/dv of the whole: by the logit, and by the logarithm of v dy/dv.
        const double byValue = byLogits[f.index] * slope + 1 / v - 1 / (v - f.low) + 1 / (f.high - v);
        (*gradient)[f.index] = v * byValue;
        (*gradient)[f.scale] -= v / x[f.scale] * slopes[f.scale] * byValue;
    }
    return value;
}

Matrix ProductTarget::FromLogits(const Matrix& y) const {
    Matrix t = y;
    for (Eigen::Index k = 0; k < y.cols(); ++k) {
        const Vector x = space_.ToNatural(y.col(k));
        for (const Factor& f : factors_) t(f.index, k) = std::log(x[f.index] * x[f.scale]);
    }
    return t;
}

Matrix ProductTarget::ToLogits(const Matrix& t) const {
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
