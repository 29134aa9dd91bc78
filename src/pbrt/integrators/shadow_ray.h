// Light on its way from a light sample to a point: through media, and through surfaces of the interface
// material.
#pragma once

#include "pbrt/base/integrator.h"
#include "pbrt/integrators/spectral_mis.h"
#include "pbrt/scene/scene.h"

namespace lacquer {

/// What is left of the light of a sample, and how densely that way was drawn.
struct ShadowRay {
    SampledSpectrum T{
        1.f};  ///< an estimate of the transmittance, not divided by the mean of pdfs.light; 0 if blocked
    SpectralPdfs pdfs;  ///< of this way alone
    /// Mean over the wavelengths of the transmittance where it is known and where a scattered ray would have
    /// to draw its way: in homogeneous media. So it depends on nothing but the way.
    float knownT = 1;
};

/// Follows a shadow ray. Homogeneous media give their exact transmittance; others are crossed by ratio
/// tracking [Novak et al. 2014], with Russian roulette where little is left.
/// @param medium  around `from`, on the side of the light; null: vacuum
ShadowRay TraceShadowRay(const Scene& scene, const LightReference& from, const LightSample& to, float time,
                         const Medium* medium, const SampledWavelengths& lambda, ThreadState& state);

/// The same from a vertex of a path, faster in scenes without media.
/// @param from    n is zero where there is no surface
/// @param w       toward the light
/// @param around  what the path has come through
ShadowRay TraceShadowRay(const Scene& scene, const SurfaceInteraction& from, const LightSample& to, Vec3 w,
                         const Medium* around, const SampledWavelengths& lambda, ThreadState& state);

}  // namespace lacquer
