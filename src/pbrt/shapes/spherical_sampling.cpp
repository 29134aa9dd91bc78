#include "pbrt/shapes/spherical_sampling.h"

#include <numbers>

#include "pbrt/core/special_functions.h"

namespace lacquer {

namespace {

using glm::dvec3;

/// Of numbers that were floats, whose squares are doubles: std::hypot() would take care of others.
double Hypotenuse(double a, double b) { return std::sqrt(a * a + b * b); }

}  // namespace

SphericalTriangle::SphericalTriangle(Point3 from, Point3 a, Point3 b, Point3 c)
    : edgeB_(dvec3(b) - dvec3(a)), edgeC_(dvec3(c) - dvec3(a)), normal_(glm::cross(edgeB_, edgeC_)) {
    const dvec3 toA = dvec3(a) - dvec3(from), toB = toA + edgeB_, toC = toA + edgeC_;
    distanceA_ = glm::length(toA);
    distanceB_ = glm::length(toB);
    a_ = toA * (1 / distanceA_);
    b_ = toB * (1 / distanceB_);
    onePlusCosB_ = 1 + glm::dot(a_, b_);
    // [Van Oosterom and Strackee 1983] eq. 8, over the distances of a and b.
    const double volume = std::abs(glm::dot(a_, normal_)) / distanceB_;
    const double sum = glm::length(toC) * onePlusCosB_ + glm::dot(a_ + b_, toC);
    const float angle = 2 * ATan2(float(volume), float(sum));
    if (std::isfinite(angle)) solidAngle_ = angle;
}

// With X = A cos(t) + T sin(t), a point on the arc from A to C at the angle t from A, the same equation for
// the triangle A B X with the solid angle 2 h is, after division by 1 + cos(t),
//     tan(t / 2) = sin(h) (1 + A.B) / (cos(h) |A, B, T| - sin(h) B.T),
// in which no term is small by cancellation where the triangle is: sine and cosine may be those of floats.
std::optional<Vec2> SphericalTriangle::Sample(Point2 u) const {
    const dvec3 acrossC = edgeC_ - a_ * glm::dot(a_, edgeC_), T = acrossC * (1 / glm::length(acrossC));
    const dvec3 normalAb = glm::cross(a_, edgeB_);
    const auto [sinH, cosH] = SinCosOfTurn(u.x * solidAngle_ * Inv4Pi);
    const double numerator = double(sinH) * onePlusCosB_;
    const double denominator = std::max(
        0., double(cosH) * std::abs(glm::dot(T, normalAb)) / distanceB_ - double(sinH) * glm::dot(b_, T));
    const double scale = 2 * numerator / (numerator * numerator + denominator * denominator);
    const dvec3 fromAToX = scale * (denominator * T - numerator * a_);

    // A point on the arc from B to X, by height over B.
    const dvec3 chord = a_ - b_ + fromAToX;
    const double full = glm::dot(chord, chord) / 2, height = double(u.y) * full;
    const double part = std::sqrt(double(u.y) * (2 - height) / std::max(2 - full, 1e-30));
    const dvec3 w = b_ * (1 - height) + part * (chord + b_ * full);

    // Where that direction meets the plane of the triangle.
    const double scaleOfW = distanceA_ / glm::dot(w, normal_);
    double b1 = scaleOfW * glm::dot(w, glm::cross(edgeC_, a_)), b2 = scaleOfW * glm::dot(w, normalAb);
    if (!std::isfinite(b1) || !std::isfinite(b2)) return std::nullopt;
    b1 = std::clamp(b1, 0., 1.);
    b2 = std::clamp(b2, 0., 1.);
    const double sum = std::max(1., b1 + b2);
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
    const double n0z = -y0_ / Hypotenuse(y0_, z0_), n1z = x1_ / Hypotenuse(x1_, z0_);
    const double n2z = y1_ / Hypotenuse(y1_, z0_), n3z = -x0_ / Hypotenuse(x0_, z0_);
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
    const double distance = Hypotenuse(xu, z0_);
    const double h0 = y0_ / Hypotenuse(distance, y0_), h1 = y1_ / Hypotenuse(distance, y1_);
    const double h = h0 + double(u.y) * (h1 - h0), cos2 = 1 - h * h;
    const double yv =
        cos2 > 1e-12 ? std::clamp(h * distance / std::sqrt(cos2), y0_, y1_) : (h > 0 ? y1_ : y0_);
    return Vec2((xu - x0_) / (x1_ - x0_), (yv - y0_) / (y1_ - y0_));
}

}  // namespace lacquer
