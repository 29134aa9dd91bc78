// Names of the objects and materials of a scene, for mattes and id channels.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace lacquer {

class Material;

/// Names, each once in its list. An object is what one ObjectInstance places, or what one Shape directive
/// outside of object definitions makes. Kept on request only: a scene may have millions of objects.
///
/// what                                       its name
/// first instance of the object "tree"        tree
/// further ones                               tree#2, tree#3, ... in the order of the files
/// shape that is read from a file             stem of that file: vase for "meshes/vase.ply"
/// any other shape                            type@file:line, as sphere@room.pbrt:12
/// material                                   its name; unnamed: type@file:line; the default one: default
///
/// A name that occurs again gets #2, #3, ... as well. Files stand without their folders, so that names (and
/// their hashes) do not depend on where a render is started.
struct SceneNames {
    std::vector<std::string> objects;  ///< SurfaceInteraction::object counts these
    std::vector<std::pair<const Material*, std::string>> materials;  ///< in the order of the files
};

}  // namespace lacquer
