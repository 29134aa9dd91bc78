// The oracle of all layered estimators: light followed through a stack, event by event, and counted where it
// leaves.
#pragma once

#include <optional>
#include <vector>

#include "layered/stack.h"

namespace lacquer::layered::test {

/// Where a walk left its stack.
struct AnalogExit {
    Vec3 wi{0, 0, 1};         ///< direction of leaving; above (z > 0) or below the stack
    SampledSpectrum weight;   ///< see AnalogWalk()
    int numVertices = 0;      ///< events at interfaces and in slabs
    bool isSpecular = false;  ///< all events were specular: a part of f that Evaluate() cannot find
};

/// A visit of a walk to an interface.
struct AnalogVisit {
    int interface;
    Vec3 wo;        ///< where the light came from, in the stack's frame
    double energy;  ///< that arrives: the weight, mean of the wavelengths, without refraction's factors
};

/// Follows light from outside through a stack until it leaves or is absorbed (then the result is empty).
///
/// The mean of `weight` over the walks that leave within a set of directions is the integral of
/// f(wo, wi, mode) |cos theta_i| over the set; the weight of lost walks counts as 0. Walks of more than
/// `maxVertices` events are lost.
///
/// Uses only BxDF::Sample of the interfaces and the Sample and Extinction of phase functions; flights, frames
/// and absorption are written out here a second time, in double precision and without any of the shortcuts
/// that estimators take. Where slabs differ over wavelengths each walk follows one wavelength, chosen with
/// equal chances: four times its weight stands in that lane, 0 in the others. Roulette ends walks with the
/// probability that the energy was lost.
/// @param visits  if not null, gets the visits in their order, also those of a lost walk
std::optional<AnalogExit> AnalogWalk(const Stack& stack, Vec3 wo, TransportMode mode, int maxVertices,
                                     Rng& rng, std::vector<AnalogVisit>* visits = nullptr);

}  // namespace lacquer::layered::test
