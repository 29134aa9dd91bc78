#include "pbrt/shapes/mesh_arrays.h"

#include <fmt/format.h>

#include "pbrt/core/progress.h"

namespace lacquer {

namespace {

bool IsFiniteElement(Vec3 v) { return IsFinite(v); }
bool IsFiniteElement(Vec2 v) { return std::isfinite(v.x) && std::isfinite(v.y); }

template <class T>
void CheckVertexAttribute(const Params& params, const char* name, const std::vector<T>& values,
                          size_t numVertices) {
    if (!values.empty() && values.size() != numVertices)
        params.Fail(
            name, fmt::format("\"{}\" has {} elements; one for each of the {} vertices of \"P\" is expected",
                              name, values.size(), numVertices));
    for (size_t i = 0; i < values.size(); ++i)
        if (!IsFiniteElement(values[i]))
            params.Fail(name,
                        fmt::format("element {} of \"{}\" is not finite; numbers are expected", i, name));
}

/// The number of elements that were not finite and are zero now.
template <class T>
size_t ZeroNonFinite(std::vector<T>* values) {
    size_t count = 0;
    for (T& value : *values) {
        if (IsFiniteElement(value)) continue;
        value = T(0);
        ++count;
    }
    return count;
}

void CheckIndices(const Params& params, const std::vector<int>& indices, int cornersPerFace,
                  size_t numVertices) {
    if (indices.size() % size_t(cornersPerFace) != 0)
        params.Fail("indices", fmt::format("\"indices\" has {} elements; a multiple of {} is expected",
                                           indices.size(), cornersPerFace));
    for (size_t i = 0; i < indices.size(); ++i)
        if (indices[i] < 0 || size_t(indices[i]) >= numVertices)
            params.Fail("indices",
                        fmt::format("element {} of \"indices\" is {}; a vertex number in [0, {}] is expected",
                                    i, indices[i], numVertices - 1));
}

}  // namespace

Vec3 WithModerateLength(Vec3 v) {
    constexpr int kMaxExponent = 40;
    const float largest = MaxComponent(Abs(v));
    if (!(largest > 0) || !std::isfinite(largest)) return v;
    const int exponent = std::ilogb(largest), moderate = std::clamp(exponent, -kMaxExponent, kMaxExponent);
    if (exponent == moderate) return v;
    const auto scaled = [&](float x) { return std::ldexp(x, moderate - exponent); };
    return {scaled(v.x), scaled(v.y), scaled(v.z)};
}

void VertexArrays::ToRendering(const Transform& renderFromObject, bool reverseOrientation,
                               const FileLoc& loc) {
    for (size_t i = 0; i < p.size(); ++i) {
        p[i] = renderFromObject.Point(p[i]);
        if (!IsFinite(p[i]))
            throw SceneError(loc,
                             fmt::format("vertex {} is too large for a float after the transformation", i));
    }
    for (Normal3& normal : n) {
        normal = renderFromObject.Normal(WithModerateLength(reverseOrientation ? -normal : normal));
        normal = WithModerateLength(normal);
        if (!IsFinite(normal)) normal = Normal3(0);
    }
    for (Vec3& tangent : s) {
        tangent = WithModerateLength(renderFromObject.Vector(WithModerateLength(tangent)));
        if (!IsFinite(tangent)) tangent = Vec3(0);
    }
}

void VertexArrays::DropNonFinite(const std::string& name, const FileLoc& loc, Observer* observer) {
    const size_t numNormals = ZeroNonFinite(&n), numUvs = ZeroNonFinite(&uv);
    if (numNormals + numUvs == 0 || !observer) return;
    observer->Warn(
        fmt::format("{}: warning: {}: of {} vertices, {} normals and {} texture coordinates are not "
                    "finite: geometry and zeros take their places",
                    loc.ToString(), name, p.size(), numNormals, numUvs));
}

size_t VertexArrays::MemoryBytes() const {
    return p.capacity() * sizeof(Point3) + n.capacity() * sizeof(Normal3) + s.capacity() * sizeof(Vec3) +
           uv.capacity() * sizeof(Point2);
}

MeshParams GetMeshParams(const Params& params, int cornersPerFace) {
    MeshParams mesh;
    VertexArrays& vertices = mesh.vertices;
    vertices.p = params.GetPoint3s("P");
    const size_t numVertices = vertices.p.size();
    if (numVertices == 0)
        params.Fail("P", fmt::format("{} needs its vertices: \"point3 P\" is expected", params.Owner()));
    CheckVertexAttribute(params, "P", vertices.p, numVertices);
    vertices.n = params.GetNormals("N");
    CheckVertexAttribute(params, "N", vertices.n, numVertices);
    vertices.uv = params.GetPoint2s("uv");
    CheckVertexAttribute(params, "uv", vertices.uv, numVertices);
    if (cornersPerFace == 3) {
        vertices.s = params.GetVector3s("S");
        CheckVertexAttribute(params, "S", vertices.s, numVertices);
    }

    // A mesh of one face needs no indices.
    mesh.indices = params.GetInts("indices");
    if (mesh.indices.empty()) {
        if (numVertices != size_t(cornersPerFace))
            params.Fail("indices",
                        fmt::format("{} has {} vertices and no indices; \"integer indices\" or exactly {} "
                                    "vertices are expected",
                                    params.Owner(), numVertices, cornersPerFace));
        for (int i = 0; i < cornersPerFace; ++i) mesh.indices.push_back(i);
    }
    CheckIndices(params, mesh.indices, cornersPerFace, numVertices);
    mesh.faceIndices = params.GetInts("faceIndices");
    const size_t numFaces = mesh.indices.size() / size_t(cornersPerFace);
    if (!mesh.faceIndices.empty() && mesh.faceIndices.size() != numFaces)
        params.Fail("faceIndices",
                    fmt::format("\"faceIndices\" has {} elements; one for each of the {} faces is expected",
                                mesh.faceIndices.size(), numFaces));
    return mesh;
}

}  // namespace lacquer
