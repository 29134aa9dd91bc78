// Other ways to draw the normals that a Beckmann surface shows than Beckmann::SampleVisible: what a baseline
// costs depends on this more than on anything else.
#pragma once

#include <span>
#include <string>

#include "pbrt/base/bxdf.h"
#include "pbrt/core/arena.h"
#include "pbrt/scattering/microfacet.h"

namespace lacquer::bench {

enum class SlopeSampler {
    Library,    ///< Beckmann::SampleVisible, in the library's own models
    Control,    ///< the same in the models below, which shows what these cost
    Newton,     ///< inversion from a plain guess, iterated to 1e-5: the slow way
    Rejection,  ///< a mixture of Gaussian and Rayleigh distribution with rejection, exact
};
struct NamedSlopeSampler {
    SlopeSampler sampler;
    const char* name;
};
/// All of them.
std::span<const NamedSlopeSampler> SlopeSamplers();

/// As Beckmann::SampleVisible.
Vec3 SampleVisible(SlopeSampler sampler, const Beckmann& facets, Vec3 w, Point2 u);
Vec3 SampleVisibleByNewton(const Beckmann& facets, Vec3 w, Point2 u);
Vec3 SampleVisibleByRejection(const Beckmann& facets, Vec3 w, Point2 u);

/// A rough dielectric (DielectricBxDF<Beckmann>) that draws its facets so. Lives in the arena.
BxDF* NewDielectric(Arena& arena, SlopeSampler sampler, Alphas alphas, float eta);
/// A rough conductor (ConductorBxDF<Beckmann>).
BxDF* NewConductor(Arena& arena, SlopeSampler sampler, Alphas alphas, SampledSpectrum eta, SampledSpectrum k);

}  // namespace lacquer::bench
