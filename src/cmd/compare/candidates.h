// What the command line of `lacquer compare` says about what is compared, and whether a scene allows it.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "cmd/compare/compare_command.h"
#include "compare/experiment.h"

namespace lacquer::cmd {

/// For CLI::Option::check(): the name of a candidate; of estimators also NAME/PDF.
CLI::Validator IsCandidate(compare::Subject subject);

/// Those of the one list that is given. Errors: usage, where one is named twice.
std::vector<compare::Candidate> CandidatesOf(const CompareArguments& arguments);

/// What renders the reference: as the arguments say, else estimator "halfvector" or integrator "volpath",
/// which render all that a scene can have. Its name is empty where it is the scene that says it. Errors:
/// usage.
compare::Candidate ReferenceCandidateOf(const CompareArguments& arguments, compare::Subject subject);
/// The sampler or light sampler of a scene.
compare::Candidate CandidateOfScene(const SceneDescription& scene, compare::Subject subject);

/// True of estimators with an error that no time takes away, and of denoisers, whose error runs share in
/// part.
bool IsApproximate(const compare::Candidate& candidate);

/// In metadata: "lightSampler".
std::string KeyOf(compare::Subject subject);

/// Whether the candidates, and what renders the reference, converge to one image of the plan's scene, and
/// whether there is anything in it that they could differ in. @param observer  for warnings; may be null
/// Errors: CLI::ValidationError.
void ExamineCandidates(const compare::ExperimentPlan& plan, const RenderSetup& setup, Observer* observer);

}  // namespace lacquer::cmd
