// Moves the meshes of a scene file into PLY files.
#pragma once

#include <functional>
#include <string>

#include "pbrt/scene/statements.h"

namespace lacquer {

/// Turns shapes "trianglemesh" of at least `minTriangles` triangles into "plymesh", which renders the same
/// image bit by bit. Meshes that a PLY file cannot hold (with "S"), that are damaged, or that give a
/// parameter twice stay as they are.
/// @param store  takes the bytes of a binary PLY file and gives the name to write into the scene
/// @return       number of meshes moved
int MoveMeshesToPly(SceneText* scene, int64_t minTriangles,
                    const std::function<std::string(const std::string& bytes)>& store);

}  // namespace lacquer
