// Vertex arrays of meshes and the parameters that give them.
#pragma once

#include <vector>

#include "pbrt/base/shape.h"

namespace lacquer {

class Observer;

/// v, or if its largest component is outside of [2^-40, 2^41), v times the power of two that takes it there:
/// a direction of any length, whose square neither overflows nor vanishes. Zero and what is not finite stays.
Vec3 WithModerateLength(Vec3 v);

/// Attributes of vertices, each array either empty or one element a vertex.
struct VertexArrays {
    std::vector<Point3> p;
    std::vector<Normal3> n;
    std::vector<Vec3> s;  ///< tangents
    std::vector<Point2> uv;

    /// Takes object space to rendering space; normals by the inverse transpose, turned around by
    /// `reverseOrientation`. Normals and tangents get a moderate length. Errors: SceneError at `loc` where a
    /// coordinate overflows.
    void ToRendering(const Transform& renderFromObject, bool reverseOrientation, const FileLoc& loc);
    /// Makes zero what is not finite of normals and texture coordinates: a zero normal leaves its share to
    /// the other corners of a face, and to the geometry where those have none either. Warns once, with the
    /// numbers. @param name  of the mesh, for the warning    @param observer  may be null
    void DropNonFinite(const std::string& name, const FileLoc& loc, Observer* observer);
    size_t MemoryBytes() const;
};

/// The face indices, in any layout, that can be checked against the number of vertices.
struct MeshParams {
    VertexArrays vertices;
    std::vector<int> indices;      ///< `cornersPerFace` for each face
    std::vector<int> faceIndices;  ///< empty or one for each face
};

/// Reads P, N, S (triangles only), uv, faceIndices and indices of `trianglemesh` (3 corners) or
/// `bilinearmesh` (4). Errors: SceneError for missing or badly sized arrays, coordinates that are not finite,
/// indices out of range.
MeshParams GetMeshParams(const Params& params, int cornersPerFace);

/// Makes 16 bytes past the end of `array` readable, as Embree asks, without changing its size.
template <class T>
void PadForEmbree(std::vector<T>* array) {
    array->reserve(array->size() + (16 + sizeof(T) - 1) / sizeof(T));
}

}  // namespace lacquer
