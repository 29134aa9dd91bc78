// One parameter of a scene, set to several values in turn.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "pbrt/scene/description.h"

namespace lacquer::compare {

/// "coat.roughness=0.1,0.2": the parameter `roughness` of the named material `coat`.
struct Variation {
    std::string target;  ///< before the equals sign
    std::vector<std::string> values;
    std::string defaultType = "float";  ///< of a parameter that neither the target nor the scene gives a type
};

/// Reads "PART.[TYPE ]PARAMETER=VALUE,VALUE,..."; a part is a material or one of PartsOf().
/// Errors: std::invalid_argument with a message for people.
Variation ParseVariation(const std::string& text);

/// Sets one of the values. Names of materials and of parameters may hold dots: the longest name that a
/// material has counts. "@1", "@2", ... are the unnamed materials in the order of the file. Without a TYPE,
/// it is that which the parameter has in the scene, else `defaultType`. Errors: std::invalid_argument for an
/// unknown part (with the nearest name), a type that cannot be written here, or a value that is none of
/// its type.
void Apply(const Variation& variation, const std::string& value, SceneDescription* scene);

/// What else has parameters beside materials, and of which type it is: camera, film, filter, sampler,
/// integrator, accelerator; light@1, ..., arealight@1, ..., shape@1, ... in the order of the file. Shapes in
/// object definitions are not among them.
std::vector<std::pair<std::string, std::string>> PartsOf(const SceneDescription& scene);

}  // namespace lacquer::compare
