#include "pbrt/shapes/spherical_sampling.h"

#include <numbers>

#include "pbrt/core/special_functions.h"

namespace lacquer {

namespace {

using glm::dvec3;

}  // namespace

SphericalTriangle::SphericalTriangle(Point3 from, Point3 a, Point3 b, Point3 c) {
    const float scale = 1 / Length(a - from);
    a_ = (a - from) * scale;
    edgeB_ = (b - a) * scale;
    edgeC_ = (c - a) * scale;
    normal_ = Cross(edgeB_, edgeC_);
    const Vec3 toB = a_ + edgeB_, toC = a_ + edgeC_;
    distanceB_ = Length(toB);
    cosB_ = Dot(a_, toB) / distanceB_;
    // [Van Oosterom and Strackee 1983] eq. 8.
    const float volume = std::abs(Dot(a_, normal_));
    const float sum = distanceB_ * (Length(toC) * (1 + cosB_) + Dot(a_, toC)) + Dot(toB, toC);
    const float angle = 2 * ATan2(volume, sum);
    if (std::isfinite(angle)) solidAngle_ = angle;
}

// With X = A cos(t) + T sin(t), a point on the arc from A to C at the angle t from A, the same equation for
// the triangle A B X with the solid angle 2 h is, after division by 1 + cos(t),
//     tan(t / 2) = sin(h) (1 + A.B) / (cos(h) |A, B, T| - sin(h) B.T),
// whose terms are all known to as many digits as the edges are, however small the triangle is.
std::optional<Vec2> SphericalTriangle::Sample(Point2 u) const {
    const Vec3 acrossC = edgeC_ - a_ * Dot(a_, edgeC_), T = acrossC / Length(acrossC);
    const Vec3 normalAb = Cross(a_, edgeB_);
    const float inverseB = 1 / distanceB_;
    const auto [sinH, cosH] = SinCosOfTurn(u.x * solidAngle_ * Inv4Pi);
    const float numerator = sinH * (1 + cosB_);
    const float denominator =
        std::max(0.f, (cosH * std::abs(Dot(T, normalAb)) - sinH * Dot(edgeB_, T)) * inverseB);
    const float scale = 2 * numerator / (numerator * numerator + denominator * denominator);
    const Vec3 fromAToX = scale * (denominator * T - numerator * a_);

    // A point on the arc from B to X, by height over B; of unit vectors only differences from A occur.
    const float longer = (2 * Dot(a_, edgeB_) + LengthSquared(edgeB_)) / (1 + distanceB_);
    const Vec3 b = (a_ + edgeB_) * inverseB, fromAToB = (edgeB_ - a_ * longer) * inverseB;
    const Vec3 chord = fromAToX - fromAToB;
    const float full = LengthSquared(chord) / 2, height = u.y * full;
    const Vec3 acrossB = chord + b * full;
    const Vec3 fromA = fromAToB - height * b + std::sqrt(u.y * (2 - height) / (2 - full)) * acrossB;

    // Where that direction meets the plane of the triangle.
    const float inverse = 1 / Dot(a_ + fromA, normal_);
    float b1 = inverse * Dot(fromA, Cross(edgeC_, a_)), b2 = inverse * Dot(fromA, normalAb);
    if (!std::isfinite(b1) || !std::isfinite(b2)) return std::nullopt;
    b1 = std::clamp(b1, 0.f, 1.f);
    b2 = std::clamp(b2, 0.f, 1.f);
    const float sum = std::max(1.f, b1 + b2);
    return Vec2(b1 / sum, b2 / sum);
}

// [Urena et al. 2013] sec. 3 and listing 1.
SphericalRectangle::SphericalRectangle(Point3 from, Point3 corner, Vec3 edgeX, Vec3 edgeY) {
    const double lengthX = glm::length(dvec3(edgeX)), lengthY = glm::length(dvec3(edgeY));
    const dvec3 x = dvec3(edgeX) / lengthX, y = dvec3(edgeY) / lengthY, z = glm::cross(x, y);
    const dvec3 d = dvec3(corner) - dvec3(from);
    z0_ = -std::abs(glm::dot(d, z));
    x0_ = glm::dot(d, x);
    y0_ = glm::dot(d, y);
    x1_ = x0_ + lengthX;
    y1_ = y0_ + lengthY;

    // Normals of the four side planes have one component that vanishes; only z and the angles between them
    // matter.
    const double n0z = -y0_ / std::hypot(y0_, z0_), n1z = x1_ / std::hypot(x1_, z0_);
    const double n2z = y1_ / std::hypot(y1_, z0_), n3z = -x0_ / std::hypot(x0_, z0_);
    const auto angle = [](double a, double b) { return std::acos(std::clamp(-a * b, -1., 1.)); };
    const double g0 = angle(n0z, n1z), g1 = angle(n1z, n2z), g2 = angle(n2z, n3z), g3 = angle(n3z, n0z);
    b0_ = n0z;
    b1_ = n2z;
    k_ = 2 * std::numbers::pi - g2 - g3;
    solidAngle_ = g0 + g1 - k_;
}

Vec2 SphericalRectangle::Sample(Point2 u) const {
    // The x at which the part to the left has the fraction u.x of the solid angle.
    const double au = double(u.x) * solidAngle_ + k_;
    const double fu = (std::cos(au) * b0_ - b1_) / std::sin(au);
    const double cu = std::clamp(std::copysign(1 / std::sqrt(fu * fu + b0_ * b0_), fu), -1., 1.);
    const double xu = std::clamp(-(cu * z0_) / std::sqrt(std::max(1e-300, 1 - cu * cu)), x0_, x1_);

    // Uniform in height on the arc at that x.
    const double distance = std::hypot(xu, z0_);
    const double h0 = y0_ / std::hypot(distance, y0_), h1 = y1_ / std::hypot(distance, y1_);
    const double h = h0 + double(u.y) * (h1 - h0), cos2 = 1 - h * h;
    const double yv =
        cos2 > 1e-12 ? std::clamp(h * distance / std::sqrt(cos2), y0_, y1_) : (h > 0 ? y1_ : y0_);
    return Vec2((xu - x0_) / (x1_ - x0_), (yv - y0_) / (y1_ - y0_));
}

}  // namespace lacquer
