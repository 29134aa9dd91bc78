// One of the ways to render a scene that are compared: what it is called, and what it changes of the scene.
#pragma once

#include <string>
#include <vector>

#include "pbrt/base/material.h"
#include "pbrt/scene/builder.h"

namespace lacquer::compare {

/// What differs between the candidates of a comparison.
enum class Subject { Estimators, Integrators, Samplers, LightSamplers, Denoisers };

/// The candidate among denoisers that leaves the image as it is.
inline constexpr const char* kNoDenoiser = "none";

/// The word for one of them: "light sampler".
const char* NounOf(Subject subject);

/// One way to render.
struct Candidate {
    std::string name;
    std::string pdf = {};  ///< of an estimator: the density for its sampling; empty: of each material
    Subject subject = Subject::Estimators;
    /// "bidirectional" or "bidirectional/gaussian".
    std::string Label() const { return pdf.empty() ? name : name + "/" + pdf; }
};

/// True if it denoises what it has rendered.
bool IsDenoised(const Candidate& candidate);

/// True if the scene's integrator widens lobes (`"bool regularize"`): an error that integrators have in
/// different ways.
bool IsRegularized(const SceneDescription& scene);
/// True if the scene's film clamps samples (`"float maxcomponentvalue"`): an error that grows with the noise
/// of a sample, and so with everything but the sampler.
bool IsClamped(const SceneDescription& scene);

/// Sets it in the scene. Estimators are no part of it: they are MaterialOverrides. An integrator that is not
/// the scene's keeps of the parameters those that it knows, and none is regularised; a sampler that is not
/// the scene's keeps none, for the count of samples and the seed are those of the run. For integrators and
/// light samplers the film does not clamp. Denoisers change nothing of the scene.
void Apply(const Candidate& candidate, SceneDescription* scene);

/// Estimator and density for every layered material; nothing for other candidates.
MaterialOverrides OverridesOf(const Candidate& candidate);

/// What a user should know of a candidate in a scene, as ends of sentences that its name begins.
struct CandidateNotes {
    std::string problem;                ///< why it renders another image, or nothing; empty: it does not
    std::vector<std::string> warnings;  ///< "has no parameter ..."
};
/// @param setup  built from `scene`, with any candidate
CandidateNotes Examine(const Candidate& candidate, const SceneDescription& scene, const RenderSetup& setup);

}  // namespace lacquer::compare
