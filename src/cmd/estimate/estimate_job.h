// The work of `lacquer estimate`: from a photograph to a folder of results.
#pragma once

#include "cmd/console.h"
#include "cmd/estimate/estimate_arguments.h"
#include "cmd/exit_status.h"

namespace lacquer::cmd {

/// Reads the photograph, finds the posterior and writes everything into --out. Errors: usage, SceneError for
/// a photograph that is none, FileError.
ExitStatus EstimateFromPhotograph(const EstimateArguments& arguments, Console* console);
/// --simulate: a synthetic photograph and its truth.
ExitStatus SimulatePhotograph(const EstimateArguments& arguments, Console* console);
/// --sbc: the method on many synthetic photographs.
ExitStatus CalibrateMethod(const EstimateArguments& arguments, Console* console);
/// --models: the table of models, as text or JSON, with priors for a camera at a distance [cm].
std::string ModelTable(bool asJson, double distance);

}  // namespace lacquer::cmd
