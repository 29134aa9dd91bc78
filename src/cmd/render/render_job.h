// One render, from arguments to written files.
#pragma once

#include <memory>

#include "cmd/console.h"
#include "cmd/exit_status.h"
#include "cmd/render/render_arguments.h"

namespace lacquer::cmd {

class JobManager;
class JobWorker;

/// Renders one image. Errors of the library pass through, for main to report.
/// @param assets   of the frames before it, and after; null: it is alone
/// @param manager  of other processes that render with it; null: it renders alone
ExitStatus RunRenderJob(const RenderArguments& arguments, std::shared_ptr<AssetCache> assets = {},
                        JobManager* manager = nullptr);

/// The part of another process in such a render: loads the scene and renders what it is given. Prints and
/// writes nothing. Errors: as RunRenderJob().
void ServeRenderJob(const RenderArguments& arguments, JobWorker* worker);

}  // namespace lacquer::cmd
