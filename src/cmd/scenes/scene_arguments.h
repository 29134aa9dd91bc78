// What the commands on scenes (render, compare, bsdf, info, convert) share.
#pragma once

#include <string>
#include <vector>

#include "pbrt/scene/parser.h"

namespace lacquer::cmd {

/// The scene files that a command line names, for ParseInputs(). "-" is standard input, which is read here to
/// its end; so is it where none is named. Errors: usage (CLI::ValidationError) for "-" twice and for a
/// terminal; SceneErrors for an empty text; FileError if it cannot be read, or is larger than scene files may
/// be.
std::vector<SceneInput> ReadSceneArguments(const std::vector<std::string>& paths);

/// The same for commands that look at materials: documents of MaterialX may be among them, and count as the
/// materials that they hold. @param observer  gets what they say that has no counterpart; may be null
/// Errors: as of materialx::ReadDocument(), too.
std::vector<SceneInput> ReadMaterialArguments(const std::vector<std::string>& paths, Observer* observer);

/// True for names of scene files, by their ending: ".pbrt" or ".pbrt.gz".
bool IsSceneName(const std::string& path);

/// Name of the first of them in messages and metadata.
std::string FirstSceneName(const std::vector<std::string>& paths);

}  // namespace lacquer::cmd
