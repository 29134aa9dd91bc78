// Tells whether a scene is still the one that a kept result was made from.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace lacquer {

/// A hash of scene files and of all files that they name: the text of scene files, followed through Include
/// and Import; of others (meshes, textures) size and time of the last change. Files are looked for where the
/// scene reader looks. What cannot be read counts by its name.
uint64_t FingerprintOfScene(const std::vector<std::string>& paths);

}  // namespace lacquer
