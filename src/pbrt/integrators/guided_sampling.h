// Draws from a mixture of scattering and what a guide has learned. Whatever it has learned, the estimate is
// unbiased: scattering draws all directions.
#pragma once

#include <optional>

#include "pbrt/base/bxdf.h"
#include "pbrt/base/interaction.h"
#include "pbrt/base/phase_function.h"
#include "pbrt/core/rng.h"
#include "pbrt/guiding/path_guide.h"
#include "pbrt/integrators/traced_path.h"

namespace lacquer {

/// Of the side of a surface where a path is.
GuidedFacing FacingOf(const SurfaceInteraction& si, const Bsdf& bsdf);

/// A direction from one of both, over the density of the mixture: the weight is f·cosine / density. Where a
/// BxDF knows its density by estimates alone, each draw asks for one: what both parts count for a direction
/// is one in the mean, since these estimates are alike.
/// @param vertex  gets what was drawn, and by what; what the path is, is left
std::optional<BxDFSample> SampleGuided(const GuidedDensity& guided, const SurfaceInteraction& si,
                                       const Bsdf& bsdf, const BxDFRandom& u, const BxDFContext& context,
                                       GuidedVertex* vertex);

/// The same for a phase function.
struct GuidedPhaseSample {
    Vec3 wi;
    SampledSpectrum weight{0.f};  ///< phase function over the density at the first wavelength
    SampledSpectrum pdf{0.f};     ///< of the mixture, at each wavelength [1/sr]
};
std::optional<GuidedPhaseSample> SampleGuided(const GuidedDensity& guided, const PhaseFunction& phase,
                                              Vec3 wo, Rng* rng, GuidedVertex* vertex);

}  // namespace lacquer
