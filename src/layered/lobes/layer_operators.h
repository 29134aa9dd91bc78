// What one interface or slab does to the energy and the spread of a beam: the atomic operators of
// [Belcour 2018].
#pragma once

#include "layered/stack.h"
#include "pbrt/scattering/microfacet.h"

namespace lacquer::layered {

/// The spread of a rough mirror, as the measure that adds up when lobes are convolved: for Trowbridge and
/// Reitz' facets the variance of [Belcour 2018], a^1.1/(1 - a^1.1); for Beckmann's that of slopes.
float SpreadOf(MicrofacetModel model, float alpha);
/// Its inverse, at most 1.
float AlphaOf(MicrofacetModel model, float spread);

/// An interface that a beam meets from one side.
struct InterfaceOperators {
    SampledSpectrum reflected{0}, transmitted{0};  ///< energies of what keeps a mean direction
    SampledSpectrum diffuse{0}, diffuseBeyond{0};  ///< of cosine lobes on either side
    float alpha = 0;                               ///< of the facets; 0: specular
    float eta = 1;                                 ///< index beyond over index on this side
};

/// @param cosTheta   of the beam's mean with the normal, in (0, 1]
/// @param alphaBeam  the beam is as wide as if facets of this alpha had been added to the interface's
/// @param rng        for BxDFs that draw
InterfaceOperators OperatorsOf(const StackInterface& interface, bool isFromAbove, float cosTheta,
                               float alphaBeam, Rng* rng);

/// What the interface does to a cosine lobe from the side for which `layer` was made, about.
struct DiffuseOperators {
    float transmitted, reflected;
};
DiffuseOperators DiffuseOperatorsOf(const InterfaceOperators& layer);

/// About the mean cosine of a phase function: that of Henyey and Greenstein's with the same peak, at least 0.
float MeanCosineOf(const PhaseFunction& phase);

/// A slab that a beam crosses. Light that it scatters forward stays in the beam; the rest is lost
/// [Belcour 2018].
struct SlabOperators {
    SampledSpectrum transmitted{1};
    float spread = 0;     ///< of Trowbridge and Reitz' measure, on average over the light
    float scattered = 0;  ///< energy that was scattered and is lost here, mean over the wavelengths
};
SlabOperators OperatorsOf(const Slab& slab, float cosTheta);

}  // namespace lacquer::layered
