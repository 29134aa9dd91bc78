// The stage of `lacquer preview` with a material of another scene on it.
#pragma once

#include <string>

#include "pbrt/core/progress.h"
#include "pbrt/scene/description.h"

namespace lacquer::cmd {

/// A ball of the material, in the light of the stage. Of `scene`, its materials and textures are kept.
/// @param material  name of a named one, or "@1", "@2", ... for the unnamed ones in the order of the file
/// Errors: SceneError for an unknown name, with the nearest one.
SceneDescription OnStage(SceneDescription scene, const std::string& material);

/// Errors: SceneError for a name that OnStage() would not know.
void CheckMaterial(const SceneDescription& scene, const std::string& name);

/// The material that a preview shows if none is named: the last of the scene. Errors: SceneError if there is
/// none.
std::string LastMaterial(const SceneDescription& scene);

}  // namespace lacquer::cmd
