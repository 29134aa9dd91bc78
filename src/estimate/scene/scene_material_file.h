// Materials as text, to be included by scenes.
#pragma once

#include <string>
#include <vector>

#include "pbrt/scene/description.h"

namespace lacquer::estimate {

/// The named materials of a description (unnamed ones as "estimated"), with the textures that they name, as
/// directives. Files keep their places: relative names are written as where they were found.
/// @param names  of materials, in an order in which each stands before those that need it
std::string MaterialText(const SceneDescription& scene, const std::vector<std::string>& names);

}  // namespace lacquer::estimate
