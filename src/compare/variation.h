// One parameter of a material, set to several values in turn.
#pragma once

#include <string>
#include <vector>

#include "pbrt/scene/description.h"

namespace lacquer::compare {

/// "coat.roughness=0.1,0.2": the parameter `roughness` of the named material `coat`.
struct Variation {
    std::string target;  ///< before the equals sign
    std::vector<std::string> values;
};

/// Reads "MATERIAL.[TYPE ]PARAMETER=VALUE,VALUE,...".
/// Errors: std::invalid_argument with a message for people.
Variation ParseVariation(const std::string& text);

/// Sets one of the values. Names of materials and of parameters may hold dots: the longest name that a
/// material has counts. "@1", "@2", ... are the unnamed materials in the order of the file. Without a TYPE,
/// it is that which the parameter has in the scene, else "float". Errors: std::invalid_argument for an
/// unknown material (with the nearest name), a type that cannot be written here, or a value that is none of
/// its type.
void Apply(const Variation& variation, const std::string& value, SceneDescription* scene);

}  // namespace lacquer::compare
