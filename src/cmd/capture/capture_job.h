// `lacquer capture`: from photographs to maps, a material and a report.
#pragma once

#include "cmd/capture/capture_arguments.h"
#include "cmd/capture/map_fitter.h"
#include "cmd/console.h"
#include "cmd/exit_status.h"

namespace lacquer::cmd {

/// Writes the card. Errors: usage, FileError.
ExitStatus WriteCard(const CaptureArguments& arguments, Console* console);

/// Errors: usage; SceneError for photographs and views that are wrong; FileError.
ExitStatus Capture(const CaptureArguments& arguments, MapFitter* fitter, Console* console);

}  // namespace lacquer::cmd
