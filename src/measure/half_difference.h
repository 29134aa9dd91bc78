// Pairs of directions by their half vector and the difference from it [Rusinkiewicz 1998].
#pragma once

#include <cmath>
#include <numbers>

#include "pbrt/core/vec.h"

namespace lacquer::measure {

inline constexpr double kPi = std::numbers::pi;

struct DirectionPair {
    Vec3 wo, wi;
};

/// Polar angle and azimuth [radians].
struct SphericalAngles {
    double theta = 0, phi = 0;
};

inline Vec3 DirectionAt(SphericalAngles a) {
    return {float(std::sin(a.theta) * std::cos(a.phi)), float(std::sin(a.theta) * std::sin(a.phi)),
            float(std::cos(a.theta))};
}

/// Turned about the normal, by the angle of a cosine and a sine.
inline Vec3 TurnedAboutNormal(Vec3 w, float cos, float sin) {
    return {cos * w.x - sin * w.y, sin * w.x + cos * w.y, w.z};
}

/// @param half        of the half vector, in the frame of the surface
/// @param difference  of wi, in the frame that turns with the half vector: about the normal by its azimuth,
///                    after about y by its polar angle
/// One of the directions may lie below the surface.
inline DirectionPair PairOfAngles(SphericalAngles half, SphericalAngles difference) {
    const Vec3 d = DirectionAt(difference);
    const Vec3 h = DirectionAt({half.theta, 0});
    const Vec3 tilted(h.z * d.x + h.x * d.z, d.y, -h.x * d.x + h.z * d.z);
    const auto c = float(std::cos(half.phi)), s = float(std::sin(half.phi));
    return {TurnedAboutNormal(Normalize(2 * Dot(tilted, h) * h - tilted), c, s),
            TurnedAboutNormal(Normalize(tilted), c, s)};
}

}  // namespace lacquer::measure
