// Vectors, points, normals, frames and boxes, over GLM. GLM does not tell points from vectors; the aliases
// say which one is meant.
#pragma once

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>
#include <glm/matrix.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "pbrt/core/math.h"

namespace lacquer {

using Vec2 = glm::vec2;
using Vec3 = glm::vec3;
using Point2 = glm::vec2;
using Point3 = glm::vec3;
using Normal3 = glm::vec3;
using Int2 = glm::ivec2;
using Int3 = glm::ivec3;
using RGB = glm::vec3;  ///< red, green, blue in some colour space
using XYZ = glm::vec3;  ///< CIE 1931 tristimulus values

inline float Dot(Vec3 a, Vec3 b) { return glm::dot(a, b); }
inline float Dot(Vec2 a, Vec2 b) { return a.x * b.x + a.y * b.y; }
inline float AbsDot(Vec3 a, Vec3 b) { return std::abs(glm::dot(a, b)); }
/// Cross product with compensated rounding, so that nearly parallel vectors keep their digits.
inline Vec3 Cross(Vec3 a, Vec3 b) {
    return {DifferenceOfProducts(a.y, b.z, a.z, b.y), DifferenceOfProducts(a.z, b.x, a.x, b.z),
            DifferenceOfProducts(a.x, b.y, a.y, b.x)};
}
inline float LengthSquared(Vec3 v) { return glm::dot(v, v); }
inline float Length(Vec3 v) { return std::sqrt(LengthSquared(v)); }
inline Vec3 Normalize(Vec3 v) { return v * (1 / Length(v)); }
inline float DistanceSquared(Point3 a, Point3 b) { return LengthSquared(a - b); }
inline Vec3 Abs(Vec3 v) { return {std::abs(v.x), std::abs(v.y), std::abs(v.z)}; }
inline float MaxComponent(Vec3 v) { return std::max({v.x, v.y, v.z}); }
inline bool IsFinite(Vec3 v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }
/// v turned into the hemisphere of `reference`.
inline Vec3 FaceForward(Vec3 v, Vec3 reference) { return Dot(v, reference) < 0 ? -v : v; }
/// Angle between two unit vectors [radians], accurate also when they are nearly (anti)parallel.
inline float AngleBetween(Vec3 a, Vec3 b) {
    if (Dot(a, b) < 0) return Pi - 2 * SafeASin(Length(a + b) / 2);
    return 2 * SafeASin(Length(b - a) / 2);
}

/// Two unit vectors that complete the unit vector `v` to a right-handed frame (x, y, v) [Duff et al. 2017].
inline void CoordinateSystem(Vec3 v, Vec3* x, Vec3* y) {
    const float sign = std::copysign(1.f, v.z);
    const float a = -1 / (sign + v.z), b = v.x * v.y * a;
    *x = {1 + sign * v.x * v.x * a, sign * b, -sign * v.x};
    *y = {b, sign + v.y * v.y * a, -v.y};
}

/// Orthonormal frame; local z is usually a shading normal.
struct Frame {
    Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};

    static Frame FromZ(Vec3 z) {
        Frame frame;
        frame.z = z;
        CoordinateSystem(z, &frame.x, &frame.y);
        return frame;
    }
    /// z exactly, x as near to the given tangent as a right angle allows; any x if they are parallel.
    static Frame FromZX(Vec3 z, Vec3 tangent) {
        const Vec3 across = tangent - z * Dot(z, tangent);
        const float length = Length(across);
        if (!(length > 1e-6f * Length(tangent)) || !std::isfinite(length)) return FromZ(z);
        const Vec3 x = across * (1 / length);
        return {x, Cross(z, x), z};
    }
    Vec3 ToLocal(Vec3 v) const { return {Dot(v, x), Dot(v, y), Dot(v, z)}; }
    Vec3 FromLocal(Vec3 v) const { return v.x * x + v.y * y + v.z * z; }
};

struct Ray {
    Point3 o{0};
    Vec3 d{0, 0, 1};  ///< need not be unit; distances along the ray are in units of its length
    float time = 0;   ///< in [shutteropen, shutterclose]
    Point3 operator()(float t) const { return o + t * d; }
};

/// Axis-aligned box; the default one is empty.
struct Bounds3 {
    Point3 min{Infinity}, max{-Infinity};

    Bounds3() = default;
    explicit Bounds3(Point3 p) : min(p), max(p) {}
    Bounds3(Point3 a, Point3 b) : min(glm::min(a, b)), max(glm::max(a, b)) {}

    bool IsEmpty() const { return !(min.x <= max.x && min.y <= max.y && min.z <= max.z); }
    Vec3 Diagonal() const { return max - min; }
    Point3 Center() const { return 0.5f * min + 0.5f * max; }
    Point3 Corner(int i) const {
        return {i & 1 ? max.x : min.x, i & 2 ? max.y : min.y, i & 4 ? max.z : min.z};
    }
    bool Contains(Point3 p) const {
        return p.x >= min.x && p.x <= max.x && p.y >= min.y && p.y <= max.y && p.z >= min.z && p.z <= max.z;
    }
    float SurfaceArea() const {
        if (IsEmpty()) return 0;
        const Vec3 d = Diagonal();
        return 2 * (d.x * d.y + d.x * d.z + d.y * d.z);
    }
    int MaxDimension() const {
        const Vec3 d = Diagonal();
        return d.x > d.y && d.x > d.z ? 0 : d.y > d.z ? 1 : 2;
    }
    Bounds3 Union(const Bounds3& b) const {
        Bounds3 r;
        r.min = glm::min(min, b.min);
        r.max = glm::max(max, b.max);
        return r;
    }
    Bounds3 Union(Point3 p) const { return Union(Bounds3(p)); }
};

/// Pixel rectangle, `max` exclusive.
struct Bounds2i {
    Int2 min{0}, max{0};
    int Width() const { return max.x - min.x; }
    int Height() const { return max.y - min.y; }
    int64_t Area() const { return IsEmpty() ? 0 : int64_t(Width()) * Height(); }
    bool IsEmpty() const { return max.x <= min.x || max.y <= min.y; }
    bool Contains(Int2 p) const { return p.x >= min.x && p.x < max.x && p.y >= min.y && p.y < max.y; }
    bool operator==(const Bounds2i&) const = default;
    Bounds2i Intersect(const Bounds2i& b) const { return {glm::max(min, b.min), glm::min(max, b.max)}; }
};

/// Unit vector from polar angle (by sine and cosine) and azimuth [radians].
inline Vec3 SphericalDirection(float sinTheta, float cosTheta, float phi) {
    return {sinTheta * std::cos(phi), sinTheta * std::sin(phi), cosTheta};
}
/// Azimuth of v in [0, 2 pi).
inline float SphericalPhi(Vec3 v) {
    const float phi = ATan2(v.y, v.x);
    return phi < 0 ? phi + 2 * Pi : phi;
}

// Angles of a unit vector in a local frame, without inverse functions.
inline float CosTheta(Vec3 w) { return w.z; }
inline float Cos2Theta(Vec3 w) { return w.z * w.z; }
inline float AbsCosTheta(Vec3 w) { return std::abs(w.z); }
inline float Sin2Theta(Vec3 w) { return std::max(0.f, 1 - w.z * w.z); }
inline bool SameHemisphere(Vec3 a, Vec3 b) { return a.z * b.z > 0; }

/// Square to sphere, equal areas: octahedral map of [Clarberg 2008]. Domain [0,1]^2, image unit vectors.
Vec3 EqualAreaSquareToSphere(Point2 p);
/// Inverse of EqualAreaSquareToSphere; d is unit.
Point2 EqualAreaSphereToSquare(Vec3 d);
/// Folds texel-space points just outside the unit square back, as the octahedral map continues them.
Point2 WrapEqualAreaSquare(Point2 p);

}  // namespace lacquer
