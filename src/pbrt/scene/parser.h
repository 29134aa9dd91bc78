// Scene files to a scene description.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pbrt/core/progress.h"
#include "pbrt/scene/description.h"

namespace lacquer {

/// Reads a scene of one or several files, which count as one text. Files that shapes, textures and the like
/// name are not opened. Names are compared as bytes: a name that is not ASCII matches only the same byte
/// sequence.
/// @param observer  gets the warnings; may be null
/// Errors  SceneErrors with everything that is wrong, at most 20 problems, each with its place;
///         FileError if a top-level file cannot be read.
SceneDescription ParseFiles(const std::vector<std::string>& paths, Observer* observer);
SceneDescription ParseFile(const std::string& path, Observer* observer);

/// A top-level text of a scene: a file, or something else that has been read already.
struct SceneInput {
    std::string name;                 ///< path of the file; of a text, its name in messages: "<stdin>"
    std::optional<std::string> text;  ///< its relative paths are looked for in the current directory
};
/// As ParseFiles().
SceneDescription ParseInputs(std::vector<SceneInput> inputs, Observer* observer);

/// The same for a text.
/// @param name       in messages: "<stdin>"
/// @param directory  where relative paths are looked for; empty: as they are written
SceneDescription ParseText(std::string text, std::string name, std::string directory, Observer* observer);

}  // namespace lacquer
