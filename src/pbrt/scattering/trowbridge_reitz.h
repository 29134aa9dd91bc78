// The Trowbridge-Reitz (GGX) distribution of microfacet normals.
#pragma once

#include "pbrt/core/rng.h"
#include "pbrt/core/special_functions.h"
#include "pbrt/core/vec.h"

namespace lacquer {

/// Normals of ellipsoids with half axes alphaX, alphaY, 1. Local frame, z along the mean normal.
/// Domain: alphas > 0. A value type; see microfacet.h for what all distributions offer.
class TrowbridgeReitz {
  public:
    TrowbridgeReitz(float alphaX, float alphaY)
        : alphaX_(alphaX), alphaY_(alphaY), invAlphaX_(1 / alphaX), invAlphaY_(1 / alphaY) {}

    float AlphaX() const { return alphaX_; }
    float AlphaY() const { return alphaY_; }

    /// Density of normals: microfacet area per solid angle of wm and unit of macroscopic area [1/sr]; it
    /// integrates to 1 with the cosine of wm. @param wm unit; the sign of wm does not matter
    float D(Vec3 wm) const {
        // [Walter et al. 2007] eq. 33 without tangents: finite also in the surface.
        const float x = wm.x * invAlphaX_, y = wm.y * invAlphaY_;
        return InvPi * invAlphaX_ * invAlphaY_ / Sqr(x * x + y * y + wm.z * wm.z);
    }
    /// Area of the microfacets that w sees, projected along w, for a unit of macroscopic area: |cos|(1 +
    /// Lambda(w)), or |cos| / G1. @param w unit, either side
    float ProjectedArea(Vec3 w) const {
        // [Heitz 2018] eq. 2 with 1 + Lambda = (1 + sqrt(1 + alpha^2 tan^2)) / 2.
        return 0.5f * (std::abs(w.z) + std::sqrt(Sqr(alphaX_ * w.x) + Sqr(alphaY_ * w.y) + w.z * w.z));
    }
    /// Normal with density D(wm) max(0, w.wm) / ProjectedArea(w). @param w unit, w.z >= 0
    /// Source: [Dupuy and Benyoub 2023], spherical caps.
    Vec3 SampleVisible(Vec3 w, Point2 u) const;
    /// The same, with more numbers from `rng` where that is faster, and no continuous function of u: no case
    /// here.
    Vec3 SampleVisible(Vec3 w, Point2 u, Rng&) const { return SampleVisible(w, u); }
    /// The inverse of SampleVisible. @param wm unit, wm.z > 0, visible from w
    Point2 InvertVisible(Vec3 w, Vec3 wm) const;

  private:
    Vec3 Stretch(Vec3 w) const { return Normalize({alphaX_ * w.x, alphaY_ * w.y, w.z}); }

    float alphaX_, alphaY_, invAlphaX_, invAlphaY_;
};

// In the space stretched by 1/alpha the facets form a hemisphere. Mirrored at its visible normals, the view
// direction covers the cap z > -w.z evenly [Dupuy and Benyoub 2023, sec. 3].
inline Vec3 TrowbridgeReitz::SampleVisible(Vec3 w, Point2 u) const {
    const Vec3 view = Stretch(w);
    // Draw the mirrored direction; 1 - z is known exactly, which keeps the digits of the sine.
    const float oneMinusZ = u.y * (1 + view.z), sinTheta = SafeSqrt(oneMinusZ * (2 - oneMinusZ));
    const auto [sin, cos] = SinCosOfTurn(u.x);
    // The half vector is the normal; stretch it back.
    const Vec3 wm{alphaX_ * (sinTheta * cos + view.x), alphaY_ * (sinTheta * sin + view.y),
                  std::max(1 - oneMinusZ + view.z, 0.f)};
    const float length2 = LengthSquared(wm);
    return length2 > 0 ? wm / std::sqrt(length2) : Vec3(0, 0, 1);
}

}  // namespace lacquer
