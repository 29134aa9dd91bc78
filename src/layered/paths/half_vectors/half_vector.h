// Half-vector product sampling: the inner directions of a path through Beckmann interfaces, drawn through the
// slopes of the facets that it meets.
//
// In the slopes m of the facets at its two ends, instead of its directions, the path's integrand is almost
// exactly Gaussian. A transmission from outside direction w, of slope s, seen in m is
//   P(m) (1 + s.m)+ G (1 - F),  P Gaussian with the covariance of the facets' slopes:
// a tilted Gaussian times factors that hardly vary. What is in the middle has the facet's slope m1, a smooth
// function of those at the ends, with a Gaussian distribution as well. So the path is a product of Gaussians,
// once m1 is made linear. Under perturbed normals all this holds of relative slopes (slopes/facet_slopes.h).
#pragma once

#include "layered/paths/interface_path.h"

namespace lacquer::layered {

/// Exists to be broken by tests.
struct HalfVectorPolicy {
    bool combinesDensities = true;  ///< the pdf of a draw has the density of the strategy not taken, too
    bool knowsNormals = true;       ///< draws by where perturbed normals turn the facets
};

/// True if the path is one that SampleHalfVectorPath() draws well: facets of Beckmann's distribution, not
/// rougher than any real surface, no end near total reflection, and no middle that turns light very far.
bool HalfVectorApplies(const InterfacePath& path);

/// A path that was drawn.
struct HalfVectorSample {
    InnerDirections inner;
    SampledSpectrum value;  ///< PathContribution(), not 0
    float pdf;              ///< over the solid angles of all inner directions [1/sr for each], > 0 and finite
};

/// Draws the inner directions of a path through Beckmann interfaces, nearly in proportion to
/// PathContribution() where HalfVectorApplies(). False for a draw of value 0, such as one that meets no facet
/// or is reflected totally.
///
/// A share of the directions is drawn as walks draw them, by the facets that are visible: at each step, and
/// the more of them the less a Gaussian knows there (rough boundaries, grazing views, directions off the
/// lobe). Tails of Gaussians are thinner than the integrand's, and weights would have no bound.
/// Random numbers from context.rng, 4 to 6 of them; 100 ns for one inner direction, 250 ns for two.
bool SampleHalfVectorPath(const InterfacePath& path, const BxDFContext& context, HalfVectorSample* sample,
                          const HalfVectorPolicy& policy = {});

/// One estimate of the path's integral: f [1/sr] of the light that takes it. Unbiased.
SampledSpectrum EstimateByHalfVectors(const InterfacePath& path, const BxDFContext& context,
                                      const HalfVectorPolicy& policy = {});

}  // namespace lacquer::layered
