// Tells whether a scene is still the one that a kept result was made from.
#pragma once

#include <cstdint>

#include "pbrt/scene/description.h"

namespace lacquer::compare {

/// A hash of everything that a scene says, whichever files say it, and of the files that its parameters name
/// (meshes, textures, spectra): their size and the time of their last change.
uint64_t FingerprintOf(const SceneDescription& scene);

}  // namespace lacquer::compare
