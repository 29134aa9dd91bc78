// The lead chain by the half-vector method that suits its interfaces.
#pragma once

#include "layered/chains/chain.h"

namespace lacquer::layered {

/// Ways to estimate a chain by the facets that it meets.
enum class LeadMethod {
    None,          ///< walks do as well
    HalfVector,    ///< Beckmann's distribution: EstimateHalfVectorChain()
    ScaleMixture,  ///< Trowbridge and Reitz': EstimateByScaleMixture()
    OneSample,     ///< EstimateByOneSample()
};

/// The method of least noise in a given time.
LeadMethod LeadMethodFor(const Chain& chain);

/// One unbiased estimate of the chain's integral [1/sr]. Random numbers from context.rng.
/// @param method  not None
SampledSpectrum EstimateLead(LeadMethod method, const Chain& chain, const BxDFContext& context);

}  // namespace lacquer::layered
