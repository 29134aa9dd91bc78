// Half-vector sampling of paths through Trowbridge-Reitz interfaces, anisotropic ones and such with perturbed
// normals too. Beckmann's distribution is a mixture of one scale, so that paths may have both; if all are
// Beckmann's, sampling without scales costs less.
//
// The slopes x of their facets are an exact mixture of Gaussians: with t ~ Exp(1),
//   1/(pi alpha^2 (1 + |x|^2/alpha^2)^2) = integral e^-t  t/(pi alpha^2) e^(-t |x|^2/alpha^2) dt;
// anisotropic ones are the same with alpha_x alpha_y for alpha^2 and x'C^-1 x/2 for |x|^2/alpha^2, C being
// diag(alpha_x^2, alpha_y^2)/2, turned with the interface.
// A few scales t for each event of a path stand for the integral. For each choice of scales the path is
// nearly Gaussian in the slopes of its outer facets, as it is for Beckmann's distribution, and the
// probabilities of all choices and of all facets are sums of closed forms. Nothing of a choice is used but
// the facet that it led to: densities are those of the whole mixture.
//
// What no Gaussian finds (facets far from a linear map, wide tails) is left to OneSample, which draws a share
// of the samples; both densities enter each weight.
#pragma once

#include "layered/paths/interface_path.h"

namespace lacquer::layered {

/// True if EstimateByScaleMixture() is expected to have less variance times time than EstimateByOneSample().
bool ScaleMixtureIsWorthwhile(const InterfacePath& path);

/// An unbiased estimate of the path's integral over its inner directions: the integrand over the density of
/// one draw; 0 for draws that fail. Random numbers from context.rng. Costs about as much as a ConnectionWalk
/// of as many vertices, twice as much as EstimateByOneSample().
/// @param countsWalks  false forgets OneSample's part of the density: wrong, for tests that must notice it
SampledSpectrum EstimateByScaleMixture(const InterfacePath& path, const BxDFContext& context,
                                       bool countsWalks = true);

}  // namespace lacquer::layered
