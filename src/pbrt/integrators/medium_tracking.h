// Free flights through media by delta tracking: collisions with the majorant, which the caller sorts into
// real and null ones [Woodcock et al. 1965; Novak et al. 2018].
#pragma once

#include <algorithm>
#include <cmath>

#include "pbrt/base/medium.h"
#include "pbrt/core/rng.h"

namespace lacquer {

/// How far a ray goes that meets nothing. Squares of lengths are finite up to here; a medium without walls
/// that is so thin that light crosses even this might as well not be there.
inline constexpr float kMaxRayDistance = 1e18f;

/// A tentative collision on a ray.
struct MajorantCollision {
    float t = 0;
    Point3 p{0};
    MediumProperties medium;  ///< what the ray meets there
    SampledSpectrum sigmaMaj{0.f};
    SampledSpectrum Tmaj{
        0.f};  ///< exp(-integral of sigmaMaj) since the last collision, or since the start of the ray
};

/// Draws collisions along a ray (unit direction) in (0, tMax) with the density sigmaMaj Tmaj of the first
/// wavelength, and calls `visit(collision)`, which returns false to stop.
/// @param u  in [0,1): the distance of the first collision; the others are drawn from rng
/// @return   Tmaj from the last collision to tMax; 1 if `visit` stopped
template <class Visitor>
SampledSpectrum TrackCollisions(const Medium& medium, const Ray& ray, float tMax, float u, Rng& rng,
                                const SampledWavelengths& lambda, Visitor&& visit) {
    const bool isDirectional = medium.IsDirectional();
    const DirectionalFactors along = medium.FactorsAlong(ray.d, lambda);
    MajorantWalk walk = medium.Majorants(ray, tMax, lambda);
    MajorantSegment segment;
    SampledSpectrum Tmaj(1);
    float opticalDepth = -std::log1p(-u);  // left until the next collision
    // Flights go at least as far as positions can tell: else one would stand still for ever where a huge
    // majorant bounds nothing.
    constexpr float kShortest = 0x1p-22f;
    const float offset = MaxComponent(glm::abs(ray.o));
    while (walk.Next(&segment)) {
        segment.sigmaMaj *= along.extinction;
        const float sigma = segment.sigmaMaj[0];
        float t = segment.tMin;
        while (opticalDepth < sigma * (segment.tMax - t)) {
            const float step = opticalDepth / sigma;
            t = std::min(t + std::max(step, kShortest * std::max(offset, t)), segment.tMax);
            Tmaj *= Exp(-step * segment.sigmaMaj);
            const Point3 p = ray.o + t * ray.d;
            MajorantCollision collision{t, p, medium.At(p, lambda), segment.sigmaMaj, Tmaj};
            if (isDirectional) collision.medium.Scale(along);
            if (!visit(collision)) return SampledSpectrum(1);
            Tmaj = SampledSpectrum(1);
            opticalDepth = -std::log1p(-rng.Uniform());
        }
        opticalDepth -= sigma * (segment.tMax - t);
        Tmaj *= Exp(-(segment.tMax - t) * segment.sigmaMaj);
    }
    return Tmaj;
}

}  // namespace lacquer
