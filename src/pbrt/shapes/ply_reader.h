// Triangles and quads from a PLY file: ASCII or binary of either byte order, perhaps gzipped.
#pragma once

#include <string>
#include <vector>

#include "pbrt/shapes/mesh_arrays.h"

namespace lacquer {

/// What a PLY file holds, in its own space. All indices are in range, all positions finite.
struct PlyMesh {
    VertexArrays vertices;
    std::vector<glm::uvec3> triangles;
    std::vector<glm::uvec4> quads;                          ///< in the order of the file: around
    std::vector<int> triangleFaceIndices, quadFaceIndices;  ///< empty or one for each face
    int64_t numIgnoredFaces = 0;                            ///< with fewer than 3 or more than 4 corners
};

/// Reads vertices (x, y, z; nx, ny, nz; u, v or s, t, also as texture_u, ...) and faces (vertex_indices or
/// vertex_index; face_indices). Other elements and properties are skipped. Time linear in the file's size.
/// Errors: FileError at `loc` for an unreadable file; SceneError at `loc` with the file's line or byte for
/// everything that is wrong inside it.
PlyMesh ReadPly(const std::string& path, const FileLoc& loc);

}  // namespace lacquer
