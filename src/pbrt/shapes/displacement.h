// Meshes refined and moved by a texture.
#pragma once

#include "pbrt/shapes/ply_reader.h"

namespace lacquer {

/// Most triangles that refinement may make.
inline constexpr size_t kMaxDisplacedTriangles = size_t(1) << 26;

/// Splits quads into triangles, halves edges, the longest of a triangle first, until all are shorter than
/// `edgeLength` under `renderFromObject`, and moves every vertex along its normal by the texture's value
/// there, in object space; the texture sees the object space's points and no footprint. Vertices without
/// normals get means of those of their faces, and so do all in the end. A triangle's neighbours halve the
/// edges that they share with it at the same points, so no gaps come up except where vertices are not shared.
/// Errors: SceneError at `loc` for a mesh without uv, a length that is not positive, values that are not
/// finite, and more than kMaxDisplacedTriangles.
void Displace(PlyMesh* mesh, const FloatTexture& displacement, const Transform& renderFromObject,
              float edgeLength, const FileLoc& loc);

}  // namespace lacquer
