// Gaussians over slopes: densities, draws and products.
#pragma once

#include "pbrt/scattering/slopes.h"

namespace lacquer {

/// A point drawn from the plane's standard normal distribution.
struct StandardNormalSample {
    Slope point;
    float square;  ///< of its length: the density is exp(-square/2) / 2 pi, nearly (1 - u.x) / 2 pi
};
/// [Box and Muller 1958]. @param u  uniform in [0,1)^2
inline StandardNormalSample SampleStandardNormal(Point2 u) {
    const float square = -2 * std::log(1 - u.x), radius = std::sqrt(square), angle = 2 * Pi * u.y;
    return {{radius * std::cos(angle), radius * std::sin(angle)}, square};
}

/// P = L L', L lower triangular, of a precision [Xia et al. 2020] eq. 17. Any finite P with a positive
/// diagonal gives one: where rounding took the definiteness, the corner of L becomes small. Draws and
/// densities both go by L, so they agree whatever happened to P.
class CholeskyFactor {
  public:
    CholeskyFactor() = default;
    explicit CholeskyFactor(const Symmetric2& p) {
        constexpr float kThinnest = 1e-6f;
        xx_ = std::sqrt(p.xx);
        overXX_ = 1 / xx_;
        yx_ = p.xy * overXX_;
        yy_ = std::sqrt(std::max(p.yy - yx_ * yx_, kThinnest * p.yy));
        overYY_ = 1 / yy_;
    }

    /// False where P was not finite or had no positive diagonal: then it must not be used.
    bool IsValid() const {
        return overXX_ > 0 && overYY_ > 0 && std::isfinite(overXX_ + overYY_ + std::abs(yx_));
    }
    /// Square root of the determinant of P.
    float Volume() const { return xx_ * yy_; }
    /// L' d: what a difference from the mean is in the plane's standard normal distribution.
    Slope ToStandard(Slope d) const { return {xx_ * d.x + yx_ * d.y, yy_ * d.y}; }
    /// The other way round.
    Slope FromStandard(Slope normal) const {
        const float dy = normal.y * overYY_;
        return {(normal.x - yx_ * dy) * overXX_, dy};
    }
    /// The d with P d = v.
    Slope Solve(Slope v) const {
        const float x = v.x * overXX_;
        return FromStandard({x, (v.y - yx_ * x) * overYY_});
    }

  private:
    float xx_ = 1, yx_ = 0, yy_ = 1;
    float overXX_ = 1, overYY_ = 1;
};

/// A Gaussian over slopes with its factor at hand, for draws and densities.
class FactoredGaussian2 {
  public:
    FactoredGaussian2() = default;
    FactoredGaussian2(Slope mean, const Symmetric2& precision) : factor_(precision), mean_(mean) {}
    /// exp(gradient' d - d' precision d / 2), d being the difference from `at`.
    FactoredGaussian2(Slope at, const Symmetric2& precision, Slope gradient)
        : factor_(precision), mean_(at + factor_.Solve(gradient)) {}

    bool IsValid() const { return factor_.IsValid() && std::isfinite(mean_.x + mean_.y); }
    Slope Mean() const { return mean_; }
    /// Pdf() of the mean.
    float Peak() const { return Inv2Pi * factor_.Volume(); }
    /// Per unit of slope area.
    float Pdf(Slope slope) const {
        const Slope normal = factor_.ToStandard(slope - mean_);
        return Peak() * std::exp(-0.5f * Dot(normal, normal));
    }
    struct SlopeSample {
        Slope slope;
        float pdf;
    };
    /// @param u  uniform in [0,1)^2
    SlopeSample Sample(Point2 u) const {
        // exp(-radius^2/2) is the number that made the radius.
        return {mean_ + factor_.FromStandard(SampleStandardNormal(u).point), Peak() * (1 - u.x)};
    }

  private:
    CholeskyFactor factor_;
    Slope mean_;
};

/// A Gaussian over slopes by what products are made of: exp(-(s - mean)' P (s - mean) / 2), with P its
/// precision, the inverse of the covariance. P is positive definite.
struct Gaussian2 {
    Slope mean;
    Symmetric2 precision{1, 0, 1};

    CholeskyFactor Factorize() const { return CholeskyFactor(precision); }
    /// Density [per unit of slope area].
    float Pdf(Slope slope) const { return FactoredGaussian2(mean, precision).Pdf(slope); }
    /// A slope drawn from it. @param u  uniform in [0,1)^2
    Slope Sample(Point2 u) const { return FactoredGaussian2(mean, precision).Sample(u).slope; }
};

/// The normalised product of two Gaussians [Xia et al. 2020] eq. A.1 to A.3.
inline Gaussian2 Multiply(const Gaussian2& a, const Gaussian2& b) {
    // The mean seen from a's: with d = mean_b - mean_a, P mean = P_b d, which keeps its digits where both
    // means are far from 0 and close to each other.
    const Symmetric2 precision = a.precision + b.precision;
    return {a.mean + CholeskyFactor(precision).Solve(b.precision * (b.mean - a.mean)), precision};
}
/// Logarithm of what the product of the densities of a and b is larger by than that of `product`, without the
/// factor 1/(2 pi) [Xia et al. 2020, eq. A.4]; very negative for Gaussians that are far apart.
inline float LogScaleOfProduct(const Gaussian2& a, const Gaussian2& b, const Gaussian2& product) {
    // s = N(mean_a | mean_b, Sigma_a + Sigma_b): its determinant is that of P over those of P_a and P_b, its
    // exponent what completing the square leaves.
    const Slope pull = b.precision * (b.mean - a.mean), rest = b.mean - product.mean;
    return -0.5f * std::max(0.f, Dot(rest, pull)) +
           std::log(a.Factorize().Volume() * b.Factorize().Volume() / product.Factorize().Volume());
}

}  // namespace lacquer
