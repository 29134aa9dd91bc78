// Slopes of directions and of facets, and the small matrices that map and spread them.
//
// The slope of a direction w is (w.x/w.z, w.y/w.z): a direction and its opposite share it, and it goes with
// the sign of z, which in a stack of layers the order of the interfaces fixes [Xia et al. 2020, sec. 5.1].
// Here because both the fitted lobes (gaussfit) and the paths of layered materials, which include those,
// compute with slopes.
#pragma once

#include "pbrt/core/vec.h"

namespace lacquer {

/// A slope, or a difference or gradient of slopes. A type of its own: a Vec3 turns into a Vec2 without a
/// word, but not into this. (And compilers keep its two numbers apart in registers, which they do not with
/// the unions of a glm vector.)
struct Slope {
    float x = 0, y = 0;

    Slope operator-() const { return {-x, -y}; }
    Slope operator+(Slope b) const { return {x + b.x, y + b.y}; }
    Slope operator-(Slope b) const { return {x - b.x, y - b.y}; }
    Slope operator*(float s) const { return {x * s, y * s}; }
    friend Slope operator*(float s, Slope a) { return a * s; }
    Slope& operator+=(Slope b) { return *this = *this + b; }
    /// Found by its arguments only, so that it hides no other Dot() in any namespace.
    friend float Dot(Slope a, Slope b) { return a.x * b.x + a.y * b.y; }
};

/// Slope of w; w.z must not be 0.
inline Slope SlopeOf(Vec3 w) { return {w.x / w.z, w.y / w.z}; }
/// What of w lies in the surface.
inline Slope PlanarPart(Vec3 w) { return {w.x, w.y}; }
/// The unit direction of a slope whose z has the sign of `side` (not 0).
inline Vec3 DirectionOf(Slope slope, float side = 1) {
    const float z = std::copysign(1 / std::sqrt(1 + Dot(slope, slope)), side);
    return {slope.x * z, slope.y * z, z};
}
/// Area of slopes per solid angle of w, 1/|cos|^3: turns a density over slopes into one over solid angle.
inline float SlopePerSolidAngle(Vec3 w) { return 1 / std::abs(w.z * w.z * w.z); }

/// Symmetric 2x2 matrix: a covariance or its inverse, a precision.
struct Symmetric2 {
    float xx = 0, xy = 0, yy = 0;

    float Determinant() const { return xx * yy - xy * xy; }
    float Trace() const { return xx + yy; }
    Slope operator*(Slope v) const { return {xx * v.x + xy * v.y, xy * v.x + yy * v.y}; }
    Symmetric2 operator*(float s) const { return {xx * s, xy * s, yy * s}; }
    Symmetric2 operator+(const Symmetric2& b) const { return {xx + b.xx, xy + b.xy, yy + b.yy}; }
    /// Adds s v v^T.
    Symmetric2 PlusSquare(float s, Slope v) const {
        return {xx + s * v.x * v.x, xy + s * v.x * v.y, yy + s * v.y * v.y};
    }
    /// The inverse of a positive definite matrix; where rounding hides that it is one, some large matrix.
    Symmetric2 Inverse() const {
        constexpr float kThinnest = 1e-6f;
        const float s = 1 / std::max(Determinant(), kThinnest * xx * yy);
        return {yy * s, -xy * s, xx * s};
    }
};

/// 2x2 matrix, rows first.
struct Matrix2 {
    float xx = 0, xy = 0, yx = 0, yy = 0;

    /// scale * (I + a b^T).
    static Matrix2 ScaledShear(float scale, Slope a, Slope b) {
        return {scale * (1 + a.x * b.x), scale * a.x * b.y, scale * a.y * b.x, scale * (1 + a.y * b.y)};
    }
    float Determinant() const { return xx * yy - xy * yx; }
    Slope operator*(Slope v) const { return {xx * v.x + xy * v.y, yx * v.x + yy * v.y}; }
    Matrix2 operator*(const Matrix2& b) const {
        return {xx * b.xx + xy * b.yx, xx * b.xy + xy * b.yy, yx * b.xx + yy * b.yx, yx * b.xy + yy * b.yy};
    }
    Slope TransposeTimes(Slope v) const { return {xx * v.x + yx * v.y, xy * v.x + yy * v.y}; }
    Matrix2 Inverse() const {
        const float over = 1 / Determinant();
        return {yy * over, -xy * over, -yx * over, xx * over};
    }
    /// M S M^T: the covariance of M v, where S is that of v.
    Symmetric2 PushForward(const Symmetric2& s) const {
        const Slope a = s * Slope{xx, xy}, b = s * Slope{yx, yy};
        return {a.x * xx + a.y * xy, a.x * yx + a.y * yy, b.x * yx + b.y * yy};
    }
    /// M^T S M: the precision of v, where S is that of M v.
    Symmetric2 PullBack(const Symmetric2& s) const { return Matrix2{xx, yx, xy, yy}.PushForward(s); }
    /// M^T M.
    Symmetric2 Gram() const { return {xx * xx + yx * yx, xx * xy + yx * yy, xy * xy + yy * yy}; }
};

}  // namespace lacquer
