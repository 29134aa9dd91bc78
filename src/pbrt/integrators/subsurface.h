// Where a path that went into a scattering medium comes out again.
#pragma once

#include "pbrt/base/bssrdf.h"
#include "pbrt/integrators/traced_path.h"

namespace lacquer {

/// A point at which the path goes on, with wo along its shading normal, and how light leaves there.
struct SubsurfaceExit {
    SurfaceInteraction si;
    Bsdf bsdf;
    SampledSpectrum Sp;   ///< as BSSRDFValue
    SampledSpectrum pdf;  ///< likewise, times the chance to choose this hit among those of the segment
};

/// Draws an exit point of the light that enters at `entry`: a probe segment, and one of its hits with
/// `material` (as its Choose() has it), all equally likely [King et al. 2013]. Four dimensions of the
/// sampler. Empty if no hit is there or no light comes out: the path ends. In a medium too dense for the
/// digits of positions, light leaves where it enters.
/// @param path  that came to the entry    @param arena  for what is at the exit
/// @param material  what was chosen at the entry; `bssrdf` is made by it
std::optional<SubsurfaceExit> SampleSubsurfaceExit(TracedPath& path, const SurfaceInteraction& entry,
                                                   const Material& material, const BSSRDF& bssrdf,
                                                   Sampler& sampler, Arena& arena);

}  // namespace lacquer
