// Refraction as a map of slopes. Where a direction w outside and u inside are joined by a facet, the facet's
// slope (x/z, y/z of its normal) is a smooth function of u's slope; along a chain such maps follow each
// other.
//
// All directions here have z > 0: w points away from the boundary, and u is opposite to the direction into
// which w is refracted. Transmission then keeps slopes, and both sides of a boundary look alike.
#pragma once

#include "pbrt/core/vec.h"

namespace lacquer::layered {

struct Matrix2 {
    float xx = 0, xy = 0, yx = 0, yy = 0;

    Vec2 operator*(Vec2 v) const { return {xx * v.x + xy * v.y, yx * v.x + yy * v.y}; }
    Matrix2 operator*(const Matrix2& b) const {
        return {xx * b.xx + xy * b.yx, xx * b.xy + xy * b.yy, yx * b.xx + yy * b.yx, yx * b.xy + yy * b.yy};
    }
    Vec2 TransposedTimes(Vec2 v) const { return {xx * v.x + yx * v.y, xy * v.x + yy * v.y}; }
    Matrix2 Inverse() const {
        const float over = 1 / (xx * yy - xy * yx);
        return {yy * over, -xy * over, -yx * over, xx * over};
    }
};

/// A symmetric matrix: a covariance or its inverse.
struct Symmetric2 {
    float xx = 0, xy = 0, yy = 0;

    /// J^T J
    static Symmetric2 Square(const Matrix2& j) {
        return {j.xx * j.xx + j.yx * j.yx, j.xx * j.xy + j.yx * j.yy, j.xy * j.xy + j.yy * j.yy};
    }
    float Determinant() const { return xx * yy - xy * xy; }
    Vec2 operator*(Vec2 v) const { return {xx * v.x + xy * v.y, xy * v.x + yy * v.y}; }
    Symmetric2 operator+(const Symmetric2& b) const { return {xx + b.xx, xy + b.xy, yy + b.yy}; }
    Symmetric2 operator*(float s) const { return {xx * s, xy * s, yy * s}; }
    /// The x with *this x = v.
    Vec2 Solve(Vec2 v) const {
        const float over = 1 / Determinant();
        return {over * (yy * v.x - xy * v.y), over * (xx * v.y - xy * v.x)};
    }
};

inline Vec2 ToSlope(Vec3 w) {
    const float over = 1 / w.z;
    return {w.x * over, w.y * over};
}
inline Vec3 ToDirection(Vec2 slope) {
    const float z = 1 / std::sqrt(1 + Dot(slope, slope));
    return {slope.x * z, slope.y * z, z};
}

/// A facet's slope and its derivative by the slope of u.
struct FacetAt {
    Vec2 slope{0};
    Matrix2 derivative;
};
/// The facet with its normal along kappa u - v. For refraction v is w and kappa the index inside over the one
/// outside; with kappa = -1 it mirrors v to u. Where normal and boundary are nearly at right angles the
/// denominator is kept from 0: no more than a guess is asked for.
inline FacetAt LineariseFacet(float kappa, Vec3 v, Vec3 u) {
    constexpr float kSmallest = 0.02f;
    const float kc = kappa * u.z, difference = kc - v.z;
    const float over = 1 / (kappa > 1 ? std::max(difference, kSmallest) : std::min(difference, -kSmallest));
    const Vec2 m{over * (kappa * u.x - v.x), over * (kappa * u.y - v.y)};
    // With u = (s, 1) c and c = (1 + s.s)^(-1/2): dc/ds = -c^3 s.
    const float a = kc * over, x = a * (u.z * m.x - u.x), y = a * (u.z * m.y - u.y);
    return {m, {a + x * u.x, x * u.y, y * u.x, a + y * u.y}};
}

/// The direction u behind a facet; one nearby where light cannot pass: a guess.
inline Vec3 GuessRefraction(float eta, Vec3 w, Vec2 facetSlope) {
    constexpr float kSmallestCos = 0.05f, kSmallestSquare = 1e-3f;
    const Vec3 h = ToDirection(facetSlope);
    const float overEta = 1 / eta, cosW = std::max(Dot(w, h), kSmallestCos);
    const float cosU = std::sqrt(std::max(1 - (1 - cosW * cosW) * overEta * overEta, kSmallestSquare));
    Vec3 u = overEta * w + (cosU - cosW * overEta) * h;
    u.z = std::max(u.z, kSmallestCos);
    return u;
}

/// The direction u behind a facet, unit. False if no light passes there.
inline bool RefractAtFacet(float eta, Vec3 w, Vec2 facetSlope, Vec3* u) {
    const Vec3 h = ToDirection(facetSlope);
    const float overEta = 1 / eta, cosW = Dot(w, h);
    if (!(cosW > 0)) return false;
    const float cos2U = 1 - (1 - cosW) * (1 + cosW) * overEta * overEta;
    if (!(cos2U > 0)) return false;
    *u = overEta * w + (std::sqrt(cos2U) - cosW * overEta) * h;
    return u->z > 0;
}

/// The facet that refracts w to u: its slope, and the area of slopes per solid angle of u [1/sr].
struct RefractingFacet {
    Vec2 slope{0};
    float slopesPerSolidAngle = 0;
};
inline RefractingFacet FacetBetween(float eta, Vec3 w, Vec3 u) {
    const Vec3 normal = eta * u - w;  // of any length and sign
    // With the normal of length 1, eta^2 |u.h| / (length^2 h.z^3): [Walter et al. 2007] eq. 17, and
    // d slope / d omega = 1/z^3.
    const float over = 1 / normal.z;
    return {over * Vec2(normal), eta * eta * std::abs(Dot(normal, u) * over * over * over)};
}

}  // namespace lacquer::layered
