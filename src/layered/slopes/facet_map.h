// The map between directions and the facets that join them: from a facet's slope to the direction behind it,
// from two directions to the slope of the facet between them, and the derivatives of both. Along a path of
// interfaces such maps follow each other.
//
// All directions here are turned up (z > 0). One behind a refraction is the opposite of where light goes
// there, the mirror image of the stack's outside: so transmission keeps slopes, and both sides of a boundary
// look alike. An index is that on the far side over that on the near side, or -1 for a reflection, which
// makes all formulas of refraction those of reflection.
#pragma once

#include "pbrt/scattering/slopes.h"

namespace lacquer::layered {

/// w or its opposite, with z > 0.
inline Vec3 Upward(Vec3 w) { return w.z < 0 ? -w : w; }

/// What a facet makes of a direction w.
struct FacetDeflection {
    Slope m;         ///< of the facet
    Vec3 u;          ///< the direction on its far side
    float cosW;      ///< of w to the facet
    float cosU;      ///< of u to the facet
    float cosFacet;  ///< of the facet's normal to z
    float length;    ///< of w - eta u, signed like 1 - eta
};
/// The same with what derivatives by m are made of.
struct LinearDeflection : FacetDeflection {
    float stretch;         ///< -length cosFacet / eta: the scale of d(u.z slope of u)/dm
    float facetPerCosine;  ///< cosFacet / cosU = 1/(u.z + m.u)
};

/// All that facets of different slopes make of one direction.
class FacetMap {
  public:
    /// @param w    unit, w.z >= 0
    /// @param eta  at 1 facets deflect nothing, and a solid angle has no area of slopes
    FacetMap(Vec3 w, float eta) : w_(w), eta_(eta), invEta_(1 / eta) {}

    /// The direction behind a facet. False where none of this slope lets light pass between the two sides.
    bool Deflection(Slope m, FacetDeflection* deflection) const {
        const Vec3 h = DirectionOf(m);
        const float cosW = Dot(w_, h);
        if (!(cosW > 0)) return false;
        const float cos2U = Cos2U(cosW);
        if (!(cos2U > 0)) return false;
        *deflection = DeflectionAt(m, h, cosW, cos2U);
        return deflection->u.z > 0;
    }
    /// Kept off the limits of total reflection and of grazing directions, where no linear model would hold: a
    /// guess there.
    LinearDeflection BoundedDeflection(Slope m) const {
        constexpr float kMinCosW = 0.05f, kMinCos2U = 1e-3f, kMinCos = 0.05f;
        const Vec3 h = DirectionOf(m);
        const float cosW = std::max(Dot(w_, h), kMinCosW);
        LinearDeflection deflection{DeflectionAt(m, h, cosW, std::max(Cos2U(cosW), kMinCos2U)), 0, 0};
        if (deflection.u.z < kMinCos) {
            deflection.u.z = kMinCos;
            deflection.u = Normalize(deflection.u);
        }
        deflection.stretch = -deflection.length * deflection.cosFacet * invEta_;
        deflection.facetPerCosine = deflection.cosFacet / deflection.cosU;
        return deflection;
    }
    /// Area of the facets' slopes per solid angle of u: [Walter et al. 2007] eq. 17, and 1/cos^3.
    float SlopesPerSolidAngle(const FacetDeflection& deflection) const {
        return deflection.cosU * Sqr(eta_ / deflection.length) /
               (deflection.cosFacet * deflection.cosFacet * deflection.cosFacet);
    }
    /// d(slope of u)/dm^T applied to a gradient over the slope of u.
    static Slope GradientOverFacet(const LinearDeflection& deflection, Slope gradient) {
        const Slope p = PlanarPart(deflection.u);
        const float c = deflection.u.z, invC = 1 / c;
        const float along = Dot(c * deflection.m - p, gradient) * deflection.facetPerCosine * invC;
        return deflection.stretch * invC * (gradient - along * p);
    }
    /// False where facets within so many standard deviations of their mean reflect totally: there the value
    /// ends at an edge, and no Gaussian does.
    bool IsFarFromTotalReflection(Slope mean, const Symmetric2& covariance, float deviations) const {
        const Vec3 h = DirectionOf(mean);
        const float cosW = Dot(w_, h);
        // d(w.h)/dm, and from it the standard deviation of cos^2 behind the facet.
        const Slope gradient = h.z * (PlanarPart(w_) - cosW * h.z * mean);
        const float deviation = 2 * cosW * Sqr(invEta_) * std::sqrt(Dot(gradient, covariance * gradient));
        return Cos2U(cosW) > deviations * deviation;
    }

  private:
    float Cos2U(float cosW) const { return 1 - (1 - cosW * cosW) * Sqr(invEta_); }
    FacetDeflection DeflectionAt(Slope m, Vec3 h, float cosW, float cos2U) const {
        const float cosU = std::sqrt(cos2U);
        // cosW - eta cosU; for refraction without the cancellation near eta = 1.
        const float length = eta_ < 0 ? cosW + cosU : (1 - eta_ * eta_) / (cosW + eta_ * cosU);
        return {m, (w_ - length * h) * invEta_, cosW, cosU, h.z, length};
    }

    Vec3 w_;
    float eta_, invEta_;
};

/// The facet that joins two directions: its normal lies along eta u - w.
class JoiningFacet {
  public:
    /// @param eta    index on the side of u over index on the side of w, -1 for a reflection
    /// @param least  For all pairs that a facet joins, eta u.z - w.z has the sign of eta - 1. It is kept at
    ///               least so far from 0: beyond, where normal and boundary are nearly at right angles, the
    ///               slope is a guess. By default nothing is bounded
    JoiningFacet(float eta, Vec3 w, Vec3 u, float least = -Infinity)
        : eta_(eta), w_(w), u_(u), sum_(KeepSign(eta, eta * u.z - w.z, least)), overSum_(1 / sum_) {
        m_ = overSum_ * (eta * PlanarPart(u) - PlanarPart(w));
    }

    Slope FacetSlope() const { return m_; }
    /// eta u.z - w.z, bounded, and its inverse.
    float Sum() const { return sum_; }
    float OverSum() const { return overSum_; }
    /// Area of slopes per solid angle of u [1/sr]. With a normal of length 1 that is eta^2 |u.h| /
    /// (|eta u - w|^2 h.z^3): [Walter et al. 2007] eq. 17, and d slope / d omega = 1/z^3.
    float SlopesPerSolidAngle() const {
        return eta_ * eta_ * std::abs(Dot(eta_ * u_ - w_, u_) * overSum_ * overSum_ * overSum_);
    }
    /// dm/d(slope of u).
    Matrix2 OverSlopeOfU() const {
        // With u = (s, 1) c and c = (1 + s.s)^(-1/2): dc/ds = -c^3 s.
        const float a = eta_ * u_.z * overSum_, x = a * (u_.z * m_.x - u_.x), y = a * (u_.z * m_.y - u_.y);
        return {a + x * u_.x, x * u_.y, y * u_.x, a + y * u_.y};
    }
    /// dm/d(slope of the facet that bends to u).
    Matrix2 OverFacetOfU(const LinearDeflection& deflection) const {
        return Matrix2::ScaledShear(eta_ * deflection.stretch * overSum_, m_ - deflection.m,
                                    PlanarPart(u_) * deflection.facetPerCosine);
    }

    /// x with the sign of eta - 1, and at least `least` from 0.
    static float KeepSign(float eta, float x, float least) {
        return eta < 1 ? std::min(x, -least) : std::max(x, least);
    }

  private:
    float eta_;
    Vec3 w_, u_;
    float sum_, overSum_;
    Slope m_;
};

}  // namespace lacquer::layered
