// How the slopes of an interface's facets are spread, in the stack's frame, and which of them a direction
// sees. Gaussian for Beckmann's distribution; of Trowbridge and Reitz' the matrix of their ellipse over 2
// stands for the covariance.
//
// Slopes h.xy/h.z of facets about the stack's normal and about another one are two views of the same
// directions h, so a projective map turns one into the other. About a perturbed normal n, of slope a =
// n.xy/n.z, a facet of slope m = a + d has
//   (h.x', h.y')/h.n = A d / (1 + v.d),   A = n.z (x.xy; y.xy),   v = n.z n.xy,
// x and y being the tangents of the interface's frame: h.n is (1 + v.d)/n.z, and h.x' is linear in d and 0 at
// d = 0, for h = (m, 1). What is called relative slope here is d / (1 + v.d): it is in the stack's frame to
// first order, and the facets' distribution in it is what it is about their own normal, Gaussian or not, with
// the covariance A^-1 diag(alpha^2/2) A^-T. The density of visible facets, D (w.h)+ in solid angle [Heitz
// 2018, eq. 3], is in it 1 + s.x times that of all facets, s being the relative slope of the direction's
// view: nothing in the models of paths needs to know that a normal is perturbed.
#pragma once

#include "layered/stack.h"
#include "pbrt/scattering/slopes.h"

namespace lacquer::layered {

/// True if facets are spread alike to all sides of the stack's normal.
inline bool IsIsotropic(const StackInterface& interface, const MicrofacetSurface& facets) {
    return facets.alphaX == facets.alphaY && interface.HasUnperturbedNormal();
}
/// Geometric mean over both axes.
inline float MeanAlpha(const MicrofacetSurface& facets) {
    return facets.alphaX == facets.alphaY ? facets.alphaX : std::sqrt(facets.alphaX * facets.alphaY);
}

/// Covariance of the facets' relative slopes: for unperturbed normals alpha^2/2 along the interface's axes.
inline Symmetric2 FacetCovariance(const StackInterface& interface, const MicrofacetSurface& surface) {
    const Symmetric2 covariance{0.5f * Sqr(surface.alphaX), 0, 0.5f * Sqr(surface.alphaY)};
    if (!interface.hasOwnFrame) return covariance;
    // The columns of A^-1.
    const Slope x = PlanarPart(interface.frame.x), y = PlanarPart(interface.frame.y);
    const float scale = 1 / Sqr(interface.frame.z.z);
    return Symmetric2{}
        .PlusSquare(covariance.xx, scale * Slope{y.y, -y.x})
        .PlusSquare(covariance.yy, scale * Slope{-x.y, x.x});
}

/// Slopes of facets relative to an interface's normal; the identity for one that is not perturbed.
class RelativeSlopes {
  public:
    RelativeSlopes() = default;
    /// @param interface  for which they exist; must outlive this
    explicit RelativeSlopes(const StackInterface& interface)
        : normal_(interface.HasUnperturbedNormal() ? nullptr : &interface.frame.z) {}

    /// True if the normal is less than 70 degrees off the stack's.
    static bool ExistFor(const StackInterface& interface) {
        constexpr float kMinCosine = 0.34f;
        return !interface.hasOwnFrame || interface.frame.z.z > kMinCosine;
    }

    bool IsPerturbed() const { return normal_ != nullptr; }

    /// The relative slope of a facet. Kept finite for facets at a right angle to the normal or beyond: a
    /// guess there, and Contains() is false.
    Slope Of(Slope slope) const {
        if (!IsPerturbed()) return slope;
        const Slope d = slope - Mean();
        return d * (1 / std::max(1 + Dot(Shear(), d), kSmallest));
    }
    /// True if a facet of this slope, turned up, is on the upper side of the interface as well.
    bool Contains(Slope slope) const {
        return !IsPerturbed() || 1 + Dot(Shear(), slope - Mean()) > kSmallest;
    }
    /// The slope of a facet, from its relative slope; kept finite as above.
    Slope ToStack(Slope x) const {
        if (!IsPerturbed()) return x;
        return Mean() + x * (1 / std::max(1 - Dot(Shear(), x), kSmallest));
    }
    /// True if the facet of this relative slope is turned up, and Contains() its slope.
    bool IsUp(Slope x) const {
        if (!IsPerturbed()) return true;
        const float shrink = 1 - Dot(Shear(), x);
        return shrink > kSmallest && shrink < 1 / kSmallest;
    }

    /// Derivative of the relative slope by the slope, at a relative slope.
    Matrix2 PerStack(Slope x) const {
        if (!IsPerturbed()) return {1, 0, 0, 1};
        return Matrix2::ScaledShear(Shrink(x), -x, Shear());
    }
    /// The inverse of that matrix.
    Matrix2 StackPer(Slope x) const {
        if (!IsPerturbed()) return {1, 0, 0, 1};
        const float stretch = 1 / Shrink(x);
        return Matrix2::ScaledShear(stretch, x * stretch, Shear());
    }
    /// Area of relative slopes per area of slopes.
    float AreaPerStack(Slope x) const {
        if (!IsPerturbed()) return 1;
        const float shrink = Shrink(x);
        return shrink * shrink * shrink;
    }
    /// s of the density 1 + s.x of visible facets. @param w  turned up; kept from grazing the interface
    Slope View(Vec3 w, float smallestCosine) const {
        if (!IsPerturbed()) return PlanarPart(w) * (1 / std::max(w.z, smallestCosine));
        return PlanarPart(w) * (normal_->z / std::max(Dot(*normal_, w), smallestCosine)) - Shear();
    }

  private:
    static constexpr float kSmallest = 0.05f;
    /// 1/(1 + v.d).
    float Shrink(Slope x) const { return std::max(1 - Dot(Shear(), x), kSmallest); }
    /// a and v of above.
    Slope Mean() const { return PlanarPart(*normal_) * (1 / normal_->z); }
    Slope Shear() const { return PlanarPart(*normal_) * normal_->z; }

    const Vec3* normal_ = nullptr;
};

/// RelativeSlopes of a normal that is not perturbed, as the compiler knows it.
class StackSlopes {
  public:
    explicit StackSlopes(const StackInterface&) {}
    static constexpr bool IsPerturbed() { return false; }
    static Slope Of(Slope slope) { return slope; }
    static bool Contains(Slope) { return true; }
    static Slope ToStack(Slope x) { return x; }
    static bool IsUp(Slope) { return true; }
    static Matrix2 PerStack(Slope) { return {1, 0, 0, 1}; }
    static Matrix2 StackPer(Slope) { return {1, 0, 0, 1}; }
    static float AreaPerStack(Slope) { return 1; }
    static Slope View(Vec3 w, float smallestCosine) {
        return PlanarPart(w) * (1 / std::max(w.z, smallestCosine));
    }
};

/// Visible facets have the density (1 + s.m)+ times that of all facets, s being the slope of the direction
/// that sees them. For a Gaussian of covariance C its peak is at t C s; this is t times `scale`.
/// @param q  s'C s
inline float ModeOfVisible(float q, float scale = 1) { return 2 * scale / (1 + std::sqrt(1 + 4 * q)); }

}  // namespace lacquer::layered
