// The Beckmann distribution of microfacet normals.
#pragma once

#include "pbrt/core/rng.h"
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
        return InvPi * invAlphaX_ * invAlphaY_ * Exp(-(x * x + y * y) / z2) / (z2 * z2);
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
    /// to three times as fast.
    Vec3 SampleVisible(Vec3 w, Point2 u, Rng& rng) const;
    /// The inverse of SampleVisible. @param wm unit, wm.z > 0, visible from w
    Point2 InvertVisible(Vec3 w, Vec3 wm) const;

  private:
    /// Projected area at alpha = 1, homogeneous of degree 1 in its arguments (sine and cosine up to a
    /// factor). |cos|(1 + Lambda) = (c (1 + erf a) + s exp(-a^2)/sqrt(pi)) / 2, a = c/s  [Heitz 2014] eq. 58
    /// (Beckmann)
    static float StretchedArea(float sinTheta, float cosTheta) {
        // Lambda is below 1e-9 from a = 4 on.
        if (cosTheta >= 4 * sinTheta) return cosTheta;
        const float a = cosTheta / sinTheta;
        return 0.5f * (cosTheta * (1 + std::erf(a)) + sinTheta * 0.56418958f * Exp(-a * a));
    }
    /// A direction in the space where alpha = 1, its azimuth taken apart.
    struct Stretched {
        float sinTheta, cosTheta, cosPhi, sinPhi;
    };
    Stretched Stretch(Vec3 w) const;
    static float SampleVisibleSlope(float sinTheta, float cosTheta, float u);
    static float SampleVisibleSlope(float sinTheta, float cosTheta, float u, Rng& rng);
    /// The normal of a slope `along` the view at alpha = 1; u draws the slope across.
    Vec3 NormalOf(const Stretched& view, float along, float u) const;

    float alphaX_, alphaY_, invAlphaX_, invAlphaY_;
};

/// Inverse of the error function on (-1, 1), relative error below 4e-7 [Giles 2010, table 5].
float ErfInv(float x);
/// A slope across any view of facets of alpha 1: Gaussian of variance 1/2. @param u  uniform in [0,1)
inline float SampleBeckmannSlope(float u) {
    return ErfInv(std::clamp(2 * u - 1, -1 + 2 * MachineEpsilon, 1 - 2 * MachineEpsilon));
}

}  // namespace lacquer
