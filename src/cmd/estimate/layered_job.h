// The work of `lacquer estimate --scene`: from a measurement to a folder of results.
#pragma once

#include "cmd/console.h"
#include "cmd/estimate/estimate_arguments.h"
#include "cmd/exit_status.h"

namespace lacquer::cmd {

/// Reads scene and measurement, finds the posterior and writes everything into --out. Errors: usage,
/// SceneError, FileError.
ExitStatus EstimateLayers(const EstimateArguments& arguments, Console* console);

}  // namespace lacquer::cmd
