// Cubic Bezier segments with a width: where a ray meets the strip that is spread along them, facing the ray.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pbrt/core/vec.h"

namespace lacquer {

/// One value for each control point: one SIMD register.
using ControlValues = float __attribute__((vector_size(16)));

/// The four control points of a cubic Bezier curve, by coordinate.
struct BezierPoints {
    ControlValues x, y, z;

    Point3 operator[](int i) const { return {x[i], y[i], z[i]}; }
    /// The curve at u in [0,1].
    Point3 At(float u) const;
    /// Its derivative by u.
    Vec3 DerivativeAt(float u) const;
};

/// Segments are cut into 2^n parts of equal length in u, n at most this.
inline constexpr int kMaxLog2CurveParts = 3;

/// The control points of part `part` of 2^log2Parts. Neighbouring parts share their end point exactly.
BezierPoints PartOf(const BezierPoints& segment, int log2Parts, int part);

/// A strip along a Bezier curve. The curve is that of u in [u0, u1] of a segment, the rest is said of the
/// whole segment.
struct CurveStrip {
    BezierPoints p;
    float u0 = 0, u1 = 1;
    float width0 = 0, width1 = 0;  ///< full widths at the ends of the segment, linear in between
    /// Ribbons: the unit normals at the ends of the segment; null for strips that face the ray.
    const Normal3* normals = nullptr;

    float WidthAt(float u) const { return Lerp(u, width0, width1); }
    /// The normal of a ribbon, turned evenly from one end to the other. Domain: normals are there.
    Normal3 NormalAt(float u) const;
    /// The width that a ray of unit direction w sees: a ribbon's is foreshortened.
    float WidthSeen(float u, Vec3 w) const {
        return normals ? WidthAt(u) * AbsDot(NormalAt(u), w) : WidthAt(u);
    }
};

/// A hit: u along the segment, v across the strip from 0 to 1, growing along d x dC/du.
struct CurveHit {
    float t = 0;
    float u = 0, v = 0;
};

/// Nearest hit with tMin < t < tMax. The ray hits where it passes the curve within half the width that it
/// sees, at the distance of the curve itself; the ends are cut off square. The strip is flat and at a right
/// angle to the ray, as wide as the ray's direction makes it: a model of thin fibres, not of a surface.
/// Cost  about 60 vector instructions where the ray misses the strip's box; else a search by halving.
std::optional<CurveHit> IntersectCurve(const Ray& ray, float tMin, float tMax, const CurveStrip& strip);

/// The control points 3n+1 of n cubic Bezier segments that share their ends, from those of a curve in one of
/// the bases of the scene format.
/// @param degree     2 or 3
/// @param isBSpline  false: Bezier, of degree * n + 1 points; true: uniform B-spline, of n + degree points
std::vector<Point3> ToCubicBezier(std::span<const Point3> p, int degree, bool isBSpline);

}  // namespace lacquer
