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

/// A Gaussian over slopes: exp(-(s - mean)' P (s - mean) / 2), with P its precision, the inverse of the
/// covariance. P is positive definite.
struct Gaussian2 {
    Slope mean;
    Symmetric2 precision{1, 0, 1};

    /// P = L L', L lower triangular [Xia et al. 2020] eq. 17. Where rounding took the definiteness, the
    /// corner of L becomes small: Draw() and Pdf() both go by L, so they agree whatever happened to P.
    struct Factor {
        float xx, yx, yy;
        /// Square root of the determinant of P.
        float Volume() const { return xx * yy; }
        /// L' d: what a difference from the mean is in the plane's standard normal distribution.
        Slope ToStandard(Slope d) const { return {xx * d.x + yx * d.y, yy * d.y}; }
        /// The other way round.
        Slope FromStandard(Slope normal) const {
            const float dy = normal.y / yy;
            return {(normal.x - yx * dy) / xx, dy};
        }
    };
    Factor Factorize() const {
        const float root = std::sqrt(precision.xx), side = precision.xy / root;
        return {root, side, std::sqrt(std::max(precision.yy - side * side, 1e-6f * precision.yy))};
    }
    /// Density [per unit of slope area].
    float Pdf(Slope slope) const {
        const Factor l = Factorize();
        const Slope normal = l.ToStandard(slope - mean);
        return l.Volume() * Inv2Pi * std::exp(-0.5f * Dot(normal, normal));
    }
    /// A slope drawn from it. @param u  uniform in [0,1)^2
    Slope Draw(Point2 u) const { return mean + Factorize().FromStandard(SampleStandardNormal(u).point); }
};

/// The normalised product of two Gaussians [Xia et al. 2020] eq. A.1 to A.3.
inline Gaussian2 Multiply(const Gaussian2& a, const Gaussian2& b) {
    Gaussian2 g{{}, a.precision + b.precision};
    // The mean seen from a's: with d = mean_b - mean_a, P mean = P_b d, which keeps its digits where both
    // means are far from 0 and close to each other.
    const Slope pull = b.precision * (b.mean - a.mean);
    const Gaussian2::Factor l = g.Factorize();
    const float u = pull.x / l.xx;
    g.mean = a.mean + l.FromStandard({u, (pull.y - l.yx * u) / l.yy});
    return g;
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

/// A Gaussian with its factor at hand, for several draws or densities. Any finite precision with a positive
/// diagonal gives a proper one.
class FactoredGaussian2 {
  public:
    FactoredGaussian2() = default;
    /// exp(gradient' d - d' precision d / 2), d being the difference from `at`.
    FactoredGaussian2(Slope at, const Symmetric2& precision, Slope gradient = {}) {
        // Rounding must not make it degenerate.
        constexpr float kThinnest = 1e-6f;
        inv11_ = 1 / std::sqrt(precision.xx);
        l21_ = precision.xy * inv11_;
        inv22_ = 1 / std::sqrt(std::max(precision.yy - l21_ * l21_, kThinnest * precision.yy));
        const float x = gradient.x * inv11_;
        mean_ = at + FromStandard({x, (gradient.y - l21_ * x) * inv22_});
    }

    /// False where the parameters that it was made from were not numbers: then it must not be used.
    bool IsValid() const {
        return inv11_ > 0 && inv22_ > 0 && std::isfinite(inv11_ + inv22_ + std::abs(l21_)) &&
               std::isfinite(mean_.x + mean_.y);
    }
    Slope Mean() const { return mean_; }
    struct Sample {
        Slope slope;
        float pdf;
    };
    Sample Draw(Point2 u) const {
        // exp(-radius^2/2) is the number that made the radius.
        return {mean_ + FromStandard(SampleStandardNormal(u).point), Peak() * (1 - u.x)};
    }
    /// Per unit of area in the plane of slopes.
    float Pdf(Slope slope) const {
        const Slope d = slope - mean_;
        const float a = d.x / inv11_ + l21_ * d.y, b = d.y / inv22_;
        return Peak() * std::exp(-0.5f * (a * a + b * b));
    }

  private:
    /// The transposed factor's inverse times a vector.
    Slope FromStandard(Slope v) const {
        const float y = v.y * inv22_;
        return {(v.x - l21_ * y) * inv11_, y};
    }
    float Peak() const { return Inv2Pi / (inv11_ * inv22_); }

    Slope mean_;
    float inv11_ = 1, l21_ = 0, inv22_ = 1;
};

}  // namespace lacquer
