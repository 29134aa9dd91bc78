// render --frames: many frames in one process.
#pragma once

#include <string>
#include <vector>

#include "cmd/exit_status.h"
#include "cmd/render/render_arguments.h"

namespace lacquer::cmd {

/// "1-5,8,10-20x5": 1, 2, 3, 4, 5, 8, 10, 15, 20. Errors: usage, also for a frame that comes twice.
std::vector<int> ParseFrames(const std::string& text);

/// The number in place of the only run of '#', with at least as many digits. @param name  without any: itself
std::string WithFrame(const std::string& name, int frame);

/// The arguments of each frame. Errors: usage, where frames would write the same file, or nothing differs.
std::vector<RenderArguments> ArgumentsOfFrames(const RenderArguments& arguments);

/// Renders one frame after another, and keeps the images of textures and the meshes that they have in common.
/// A frame that fails does not stop the others. @return  the first status that is not Complete
ExitStatus RunSequence(const RenderArguments& arguments);

}  // namespace lacquer::cmd
