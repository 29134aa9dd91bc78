// One render, from arguments to written files.
#pragma once

#include <memory>

#include "cmd/console.h"
#include "cmd/exit_status.h"
#include "cmd/render/render_arguments.h"

namespace lacquer::cmd {

/// Renders one image. Errors of the library pass through, for main to report.
ExitStatus RunRenderJob(const RenderArguments& arguments);

}  // namespace lacquer::cmd
