// lacquer convert on scenes: formats them, moves meshes to PLY files, upgrades pbrt-v3.
#pragma once

#include "cmd/exit_status.h"
#include "cmd/images/convert_command.h"

namespace lacquer::cmd {

/// Writes to the output file, or to stdout where there is none. Errors: usage, SceneError, FileError.
ExitStatus RunConvertScene(const ConvertArguments& arguments);

}  // namespace lacquer::cmd
