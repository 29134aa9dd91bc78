// One render, from arguments to written files.
#pragma once

#include <memory>

#include "cmd/console.h"
#include "cmd/exit_status.h"
#include "cmd/render/render_arguments.h"

namespace lacquer::cmd {

/// Renders one image. Errors of the library pass through, for main to report.
/// @param assets  of the frames before it, and after; null: it is alone
ExitStatus RunRenderJob(const RenderArguments& arguments, std::shared_ptr<AssetCache> assets = {});

}  // namespace lacquer::cmd
