// lacquer convert on scenes: formats them, moves meshes to PLY files, upgrades pbrt-v3.
#pragma once

#include "cmd/convert_command.h"
#include "cmd/exit_status.h"

namespace lacquer {

/// Writes to the output file, or to stdout where there is none. Errors: usage, SceneError, FileError.
ExitStatus RunConvertScene(const ConvertArguments& arguments);

}  // namespace lacquer
