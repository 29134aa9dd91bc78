// The shortest path by the half-vector method that suits its interfaces.
#pragma once

#include "layered/paths/interface_path.h"

namespace lacquer::layered {

/// Ways to estimate a path by the facets that it meets.
enum class ShortestPathMethod {
    None,          ///< walks do better
    HalfVector,    ///< Beckmann's distribution: EstimateByHalfVectors()
    ScaleMixture,  ///< Trowbridge and Reitz': EstimateByScaleMixture()
    OneSample,     ///< EstimateByOneSample()
};

/// The method of least noise in a given time.
ShortestPathMethod ShortestPathMethodFor(const InterfacePath& path);

/// One unbiased estimate of the path's integral [1/sr]. Random numbers from context.rng.
/// @param method  not None
SampledSpectrum EstimateShortestPath(ShortestPathMethod method, const InterfacePath& path,
                                     const BxDFContext& context);

}  // namespace lacquer::layered
