// The azimuth of a reflection by isotropic facets, relative to that of the mirror direction, where the
// cosines c1, c2 of both directions are known. With q = s1 s2 and p = 1 + c1 c2 the facets' D is
//   Beckmann             exp(kappa cos psi) (p - q cos psi)^2,  kappa = 2 q / (alpha (c1 + c2))^2,
//   Trowbridge and Reitz ((p - q cos psi) / (b - q cos psi))^2,  b = p - (1 - alpha^2) (c1 + c2)^2 / 2,
// up to factors free of psi, and nothing else in the reflection but Fresnel's factor depends on psi.
#pragma once

#include "pbrt/core/rng.h"
#include "pbrt/scattering/microfacet.h"

namespace lacquer::layered {

/// An angle by its cosine and sine, and the density with which it was drawn [1/rad].
struct AzimuthSample {
    float cos, sin, pdf;
};

/// Cosine and sine of a direction's angle to the normal.
struct PolarAngle {
    float cos, sin;
};

AzimuthSample SampleAzimuth(const Beckmann& facets, PolarAngle w1, PolarAngle w2, Point2 u);
AzimuthSample SampleAzimuth(const TrowbridgeReitz& facets, PolarAngle w1, PolarAngle w2, Point2 u);

}  // namespace lacquer::layered
