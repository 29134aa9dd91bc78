// Media of oriented mirrors (microflakes): extinction and scattering depend on the direction [Jakob et al.
// 2010]. The flakes are two-sided specular mirrors that lose nothing; losses are the medium's albedo.
//
// Both kinds are reciprocal: Extinction(wo) p(wo, wi) is a function of the half vector alone.
#pragma once

#include "pbrt/phases/angular.h"

namespace lacquer {

/// z along the axis; the identity where that has no direction.
inline Frame FrameAlong(Vec3 axis) {
    const float length = Length(axis);
    return length > 0 && std::isfinite(length) ? Frame::FromZ(axis / length) : Frame{};
}

/// The normal that mirrors wo into wi. Light that goes straight on only grazes flakes; any that contains the
/// direction will do there.
inline Vec3 HalfVector(Vec3 wo, Vec3 wi) {
    const Vec3 h = wo + wi;
    if (LengthSquared(h) > 0) return Normalize(h);
    Vec3 x, y;
    CoordinateSystem(wo, &x, &y);
    return x;
}

/// Mirror direction; its length must not drift in long walks.
inline Vec3 Mirror(Vec3 wo, Vec3 m) { return Normalize(2 * Dot(wo, m) * m - wo); }

}  // namespace lacquer
