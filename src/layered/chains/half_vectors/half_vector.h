// Half-vector product sampling: the inner directions of a chain of Beckmann interfaces, drawn through the
// slopes of the facets that it meets.
//
// In the slopes m of the facets at its two ends, instead of its directions, the chain's integrand is almost
// exactly Gaussian. A transmission from outside direction w, of slope s, seen in m is
//   P(m) (1 + s.m)+ G (1 - F),  P Gaussian with the covariance of the facets' slopes:
// a tilted Gaussian times factors that hardly vary. What is in the middle has the facet's slope m1, a smooth
// function of those at the ends, with a Gaussian law as well. So the chain is a product of Gaussians, once m1
// is made linear.
#pragma once

#include "layered/chains/chain.h"

namespace lacquer::layered {

/// Exists to be broken by tests.
struct HalfVectorPolicy {
    bool combinesDensities = true;  ///< the pdf of a draw has the density of the strategy not taken, too
};

/// True if the chain is one that DrawHalfVectorChain() draws well: facets of Beckmann's distribution, not
/// rougher than any real surface, and no end near total reflection.
bool HalfVectorApplies(const Chain& chain);

/// Draws the inner directions of a chain of Beckmann interfaces, nearly in proportion to ChainValue() where
/// HalfVectorApplies(). False for a draw that meets no facet or is reflected totally: a sample of value 0.
/// @param pdf  over the solid angles of all inner directions [1/sr for each], > 0 and finite
/// Takes 3 to 6 random numbers; 100 ns for one inner direction, 250 ns for two.
bool DrawHalfVectorChain(const Chain& chain, Rng& rng, ChainDirections* inner, float* pdf,
                         const HalfVectorPolicy& policy = {});

/// One estimate of the chain's integral: f [1/sr] of the light that takes it. Unbiased.
SampledSpectrum EstimateHalfVectorChain(const Chain& chain, Rng& rng, TransportMode mode,
                                        const HalfVectorPolicy& policy = {});

}  // namespace lacquer::layered
