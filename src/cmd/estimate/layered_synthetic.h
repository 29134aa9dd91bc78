// Synthetic measurements of layers: one with its truth, and many that test the method.
#pragma once

#include "cmd/console.h"
#include "cmd/estimate/estimate_arguments.h"
#include "cmd/exit_status.h"

namespace lacquer::cmd {

/// --simulate with --scene: a CSV with noise, its directions those of the data if there are any, and its
/// truth as FILE.json. Errors: usage, SceneError, FileError.
ExitStatus SimulateLayers(const EstimateArguments& arguments, Console* console);
/// --sbc with --scene.
ExitStatus CalibrateLayers(const EstimateArguments& arguments, Console* console);

}  // namespace lacquer::cmd
