// The Beckmann distribution of microfacet normals.
#pragma once

#include "pbrt/core/rng.h"
#include "pbrt/core/special_functions.h"
#include "pbrt/core/vec.h"

namespace lacquer {

/// Normals of a surface with Gaussian slopes of variance alpha^2 / 2 along x and y. Local frame, z along the
/// mean normal. Domain: alphas > 0. A value type; see microfacet.h for what all distributions offer.
class Beckmann {
  public:
    Beckmann(float alphaX, float alphaY)
        : alphaX_(alphaX), alphaY_(alphaY), invAlphaX_(1 / alphaX), invAlphaY_(1 / alphaY) {}

    float AlphaX() const { return alphaX_; }
    float AlphaY() const { return alphaY_; }

    /// As TrowbridgeReitz::D. [Walter et al. 2007] eq. 25
    float D(Vec3 wm) const {
        const float x = wm.x * invAlphaX_, y = wm.y * invAlphaY_, z2 = wm.z * wm.z;
        // Below this cosine the exponential is zero in single precision.
        if (!(x * x + y * y < 80 * z2)) return 0;
        const float over = 1 / z2;
        return InvPi * invAlphaX_ * invAlphaY_ * Exp(-(x * x + y * y) * over) * (over * over);
    }
    /// As TrowbridgeReitz::ProjectedArea, with the exact Lambda of Smith (error function), no fit.
    float ProjectedArea(Vec3 w) const {
        const float sinTheta = std::sqrt(Sqr(alphaX_ * w.x) + Sqr(alphaY_ * w.y));
        return StretchedArea(sinTheta, std::abs(w.z));
    }
    /// As TrowbridgeReitz::SampleVisible. The slopes are drawn by inverting their marginal distribution: a
    /// closed-form guess and a step of Halley's method; the residual of the distribution function is below
    /// 2e-6.
    Vec3 SampleVisible(Vec3 w, Point2 u) const;
    /// The same, with more numbers from `rng`, and no continuous function of u: exact, by rejection, and up
    /// to three times as fast. Inline, for walks wait for it at each vertex.
    Vec3 SampleVisible(Vec3 w, Point2 u, Rng& rng) const;
    /// The inverse of SampleVisible. @param wm unit, wm.z > 0, visible from w
    Point2 InvertVisible(Vec3 w, Vec3 wm) const;

  private:
    static constexpr float kSqrtPi = 1.77245385f, kInvSqrtPi = 0.56418958f;

    /// Projected area at alpha = 1, homogeneous of degree 1 in its arguments (sine and cosine up to a
    /// factor). |cos|(1 + Lambda) = (c (1 + erf a) + s exp(-a^2)/sqrt(pi)) / 2, a = c/s  [Heitz 2014] eq. 58
    /// (Beckmann).
    static float StretchedArea(float sinTheta, float cosTheta) {
        // Lambda is below 2e-8 from a = 3.5 on.
        if (cosTheta >= 3.5f * sinTheta) return cosTheta;
        const float a = cosTheta / sinTheta;
        return cosTheta + 0.5f * Exp(-a * a) * (sinTheta * kInvSqrtPi - cosTheta * ScaledErfc(a));
    }
    /// A direction in the space where alpha = 1, up to its length, and its azimuth taken apart.
    struct Stretched {
        float sinTheta, cosTheta, cosPhi, sinPhi;
    };
    Stretched Stretch(Vec3 w) const {
        const float x = alphaX_ * w.x, y = alphaY_ * w.y, planar2 = x * x + y * y;
        if (!(planar2 > std::numeric_limits<float>::min())) return {0, w.z, 1, 0};
        const float over = 1 / std::sqrt(planar2);
        return {planar2 * over, w.z, x * over, y * over};
    }
    /// Arguments up to a factor.
    static float SampleVisibleSlope(float sinTheta, float cosTheta, float u);
    /// The normal of slopes along and across the view at alpha = 1.
    Vec3 NormalOf(const Stretched& view, float along, float across) const {
        // Turn them back to the azimuth of w and stretch them.
        const float slopeX = alphaX_ * (view.cosPhi * along - view.sinPhi * across);
        const float slopeY = alphaY_ * (view.sinPhi * along + view.cosPhi * across);
        return Normalize({-slopeX, -slopeY, 1});
    }

    float alphaX_, alphaY_, invAlphaX_, invAlphaY_;
};

/// A slope across any view of facets of alpha 1: Gaussian of variance 1/2. @param u  uniform in [0,1)
inline float SampleBeckmannSlope(float u) {
    return ErfInv(std::clamp(2 * u - 1, -1 + 2 * MachineEpsilon, 1 - 2 * MachineEpsilon));
}

// The slope along the view has the density cos exp(-x^2) + (-x)+ sin exp(-x^2) of a Gaussian and of a
// Rayleigh half, of which facets turned away from the view (x > 0) keep the share 1 - x tan.
inline Vec3 Beckmann::SampleVisible(Vec3 w, Point2 u, Rng& rng) const {
    const Stretched view = Stretch(w);
    const float rayleigh = 0.5f * view.sinTheta, gauss = view.cosTheta * kSqrtPi;
    for (;; u = rng.Uniform2D()) {
        const float radius = std::sqrt(-Log(1 - u.x));
        if (rng.Uniform() * (rayleigh + gauss) < rayleigh)
            return NormalOf(view, -radius, SampleBeckmannSlope(u.y));
        // A pair of Gaussian slopes [Box and Muller 1958]. Those towards the view pass by themselves: to ask
        // for their sign first would save a number and cost a branch that nobody can predict.
        const auto [sin, cos] = SinCosOfTurn(u.y);
        const float along = radius * cos;
        if (!(rng.Uniform() * view.cosTheta >= view.cosTheta - along * view.sinTheta))
            return NormalOf(view, along, radius * sin);
    }
}

}  // namespace lacquer
