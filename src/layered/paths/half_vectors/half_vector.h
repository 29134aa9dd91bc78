// Half-vector product sampling: the inner directions of a path through Beckmann interfaces, drawn through the
// slopes of the facets that it meets.
//
// In the slopes m of the facets at its two ends, instead of its directions, the path's integrand is almost
// exactly Gaussian. A transmission from outside direction w, of slope s, seen in m is
//   P(m) (1 + s.m)+ G (1 - F),  P Gaussian with the covariance of the facets' slopes:
// a tilted Gaussian times factors that hardly vary. What is in the middle has the facet's slope m1, a smooth
// function of those at the ends, with a Gaussian distribution as well. So the path is a product of Gaussians,
// once m1 is made linear.
#pragma once

#include "layered/paths/interface_path.h"

namespace lacquer::layered {

/// Exists to be broken by tests.
struct HalfVectorPolicy {
    bool combinesDensities = true;  ///< the pdf of a draw has the density of the strategy not taken, too
};

/// True if the path is one that SampleHalfVectorPath() draws well: facets of Beckmann's distribution, not
/// rougher than any real surface, and no end near total reflection.
bool HalfVectorApplies(const InterfacePath& path);

/// Draws the inner directions of a path through Beckmann interfaces, nearly in proportion to
/// PathContribution() where HalfVectorApplies(). False for a draw that meets no facet or is reflected
/// totally: a sample of value 0.
/// @param pdf  over the solid angles of all inner directions [1/sr for each], > 0 and finite
/// Takes 3 to 6 random numbers; 100 ns for one inner direction, 250 ns for two.
bool SampleHalfVectorPath(const InterfacePath& path, Rng& rng, InnerDirections* inner, float* pdf,
                          const HalfVectorPolicy& policy = {});

/// One estimate of the path's integral: f [1/sr] of the light that takes it. Unbiased.
SampledSpectrum EstimateByHalfVectors(const InterfacePath& path, Rng& rng, TransportMode mode,
                                      const HalfVectorPolicy& policy = {});

}  // namespace lacquer::layered
