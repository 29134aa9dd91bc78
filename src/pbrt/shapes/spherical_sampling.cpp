#include "pbrt/shapes/spherical_sampling.h"

#include <numbers>

namespace lacquer {

namespace {

using glm::dvec3;

}  // namespace

SphericalTriangle::SphericalTriangle(Point3 from, Point3 a, Point3 b, Point3 c)
    : edgeB_(dvec3(b) - dvec3(a)),
      edgeC_(dvec3(c) - dvec3(a)),
      origin_(dvec3(from) - dvec3(a)),
      a_(glm::normalize(-origin_)),
      b_(glm::normalize(edgeB_ - origin_)),
      c_(glm::normalize(edgeC_ - origin_)) {
    // [Van Oosterom and Strackee 1983] eq. 8, for unit vectors.
    const double volume = std::abs(glm::dot(a_, glm::cross(b_ - a_, c_ - a_)));
    const double sum = 1 + glm::dot(a_, b_) + glm::dot(b_, c_) + glm::dot(a_, c_);
    solidAngle_ = 2 * std::atan2(volume, sum);
    if (!std::isfinite(solidAngle_)) solidAngle_ = 0;
}

std::optional<Vec2> SphericalTriangle::Sample(Point2 u) const {
    // The angle alpha at corner A, between the planes of AB and AC, by its sine and cosine.
    const dvec3 normalAb = glm::cross(a_, b_), normalAc = glm::cross(a_, c_);
    const double cosScaled = glm::dot(normalAb, normalAc),
                 sinScaled = std::abs(glm::dot(a_, glm::cross(normalAb, normalAc)));
    const double scale = 1 / std::sqrt(cosScaled * cosScaled + sinScaled * sinScaled);
    const double sinAlpha = sinScaled * scale, cosAlpha = cosScaled * scale, cosC = glm::dot(a_, b_);

    // [Arvo 1995] fig. 2: the sub-triangle A B C' with the fraction u.x of the solid angle; q = cos of its
    // side AC'.
    const double sinArea = std::sin(double(u.x) * solidAngle_), cosArea = std::cos(double(u.x) * solidAngle_);
    const double s = sinArea * cosAlpha - cosArea * sinAlpha, r = cosArea * cosAlpha + sinArea * sinAlpha;
    const double p = r - cosAlpha, v = s + sinAlpha * cosC;
    const double denominator = (v * s + p * r) * sinAlpha;
    double q = denominator != 0 ? ((v * r - p * s) * cosAlpha - v) / denominator : 1.;
    q = std::clamp(q, -1., 1.);
    const dvec3 towardC = glm::normalize(c_ - a_ * glm::dot(a_, c_));
    const dvec3 cNew = q * a_ + std::sqrt(1 - q * q) * towardC;

    // A point on the arc from B to C', by height over B.
    const double z = 1 - double(u.y) * (1 - glm::dot(cNew, b_));
    const dvec3 towardCNew = cNew - b_ * glm::dot(b_, cNew);
    const double length = glm::length(towardCNew);
    dvec3 w = b_;
    if (length > 0) w = z * b_ + std::sqrt(std::max(0., 1 - z * z)) / length * towardCNew;

    // Where that direction meets the plane of the triangle.
    const dvec3 h = glm::cross(w, edgeC_);
    const double determinant = glm::dot(edgeB_, h);
    double b1 = glm::dot(origin_, h) / determinant;
    double b2 = glm::dot(w, glm::cross(origin_, edgeB_)) / determinant;
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
