#include "pbrt/shapes/displacement.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <utility>

#include <fmt/format.h>

namespace lacquer {

namespace {

void SplitQuads(PlyMesh* mesh) {
    const bool hasFaces = !mesh->quadFaceIndices.empty() || !mesh->triangleFaceIndices.empty();
    // Faces without a number count as 0 in a mesh where others have one.
    if (hasFaces) mesh->triangleFaceIndices.resize(mesh->triangles.size());
    for (size_t i = 0; i < mesh->quads.size(); ++i) {
        const glm::uvec4 q = mesh->quads[i];
        mesh->triangles.push_back({q.x, q.y, q.z});
        mesh->triangles.push_back({q.x, q.z, q.w});
        const int face = i < mesh->quadFaceIndices.size() ? mesh->quadFaceIndices[i] : 0;
        if (hasFaces) mesh->triangleFaceIndices.insert(mesh->triangleFaceIndices.end(), 2, face);
    }
    mesh->quads.clear();
    mesh->quadFaceIndices.clear();
}

/// Means of the unit normals of the faces around each vertex; zero where there are none.
std::vector<Normal3> MeanNormals(const std::vector<Point3>& p, const std::vector<glm::uvec3>& triangles) {
    std::vector<Normal3> normals(p.size(), Normal3(0));
    for (const glm::uvec3 t : triangles) {
        const Vec3 n = glm::cross(p[t.y] - p[t.x], p[t.z] - p[t.x]);
        const float length = glm::length(n);
        if (!(length > 0)) continue;
        for (int k = 0; k < 3; ++k) normals[t[k]] += n / length;
    }
    for (Normal3& n : normals) {
        const float length = glm::length(n);
        if (length > 0) n /= length;
    }
    return normals;
}

/// Halves the edges of a mesh that are too long.
class Refiner {
  public:
    Refiner(PlyMesh* mesh, const Transform& renderFromObject, float edgeLength, const FileLoc& loc)
        : mesh_(*mesh), edgeLength_(edgeLength), loc_(loc), renderFromObject_(renderFromObject) {
        for (const Point3 p : mesh_.vertices.p) rendered_.push_back(renderFromObject.Point(p));
    }

    void Run() {
        CheckArea();
        const std::vector<glm::uvec3> coarse = std::exchange(mesh_.triangles, {});
        const std::vector<int> coarseFaces = std::exchange(mesh_.triangleFaceIndices, {});
        for (size_t i = 0; i < coarse.size(); ++i) {
            face_ = coarseFaces.empty() ? nullptr : &coarseFaces[i];
            Refine(coarse[i]);
        }
    }

  private:
    [[noreturn]] void TooMany() const {
        throw SceneError(loc_, fmt::format("displacement with an edge length of {} makes more than {} "
                                           "triangles; a larger \"edgelength\" is expected",
                                           edgeLength_, kMaxDisplacedTriangles));
    }

    /// Finds soon what would take long: no triangle of short edges is larger than one of three equal ones.
    void CheckArea() const {
        double area = 0;
        for (const glm::uvec3 t : mesh_.triangles)
            area += 0.5 * double(glm::length(
                              glm::cross(rendered_[t.y] - rendered_[t.x], rendered_[t.z] - rendered_[t.x])));
        const double largest = std::sqrt(3.0) / 4 * double(edgeLength_) * double(edgeLength_);
        if (area > largest * double(kMaxDisplacedTriangles)) TooMany();
    }

    float Length(uint32_t a, uint32_t b) const { return glm::distance(rendered_[a], rendered_[b]); }

    /// Depth: each level halves the longest edge, so it grows with the logarithm of the size only.
    void Refine(glm::uvec3 t) {
        const float lengths[3] = {Length(t.x, t.y), Length(t.y, t.z), Length(t.z, t.x)};
        const int longest = int(std::max_element(lengths, lengths + 3) - lengths);
        // An edge that floats cannot halve stays as it is.
        const uint32_t middle =
            lengths[longest] < edgeLength_ ? kNone : Middle(t[longest], t[(longest + 1) % 3]);
        if (middle == kNone) return Emit(t);
        const uint32_t a = t[longest], b = t[(longest + 1) % 3], c = t[(longest + 2) % 3];
        Refine({a, middle, c});
        Refine({middle, b, c});
    }

    void Emit(glm::uvec3 t) {
        if (mesh_.triangles.size() == kMaxDisplacedTriangles) TooMany();
        mesh_.triangles.push_back(t);
        if (face_) mesh_.triangleFaceIndices.push_back(*face_);
    }

    /// The vertex between two others, the same for all triangles around them.
    uint32_t Middle(uint32_t a, uint32_t b) {
        const uint64_t edge = uint64_t(std::min(a, b)) << 32 | std::max(a, b);
        const auto [it, isNew] = middles_.try_emplace(edge, kNone);
        if (!isNew) return it->second;
        VertexArrays& v = mesh_.vertices;
        const Point3 p = 0.5f * (v.p[a] + v.p[b]);
        if (p == v.p[a] || p == v.p[b]) return kNone;
        v.p.push_back(p);
        v.uv.push_back(0.5f * (v.uv[a] + v.uv[b]));
        const Normal3 n = v.n[a] + v.n[b];
        const float length = glm::length(n);
        v.n.push_back(length > 0 ? n / length : v.n[a]);
        rendered_.push_back(renderFromObject_.Point(p));
        return it->second = uint32_t(v.p.size() - 1);
    }

    static constexpr uint32_t kNone = 0xffffffffu;
    PlyMesh& mesh_;
    float edgeLength_;
    const FileLoc& loc_;
    const Transform& renderFromObject_;
    std::vector<Point3> rendered_;
    std::unordered_map<uint64_t, uint32_t> middles_;
    const int* face_ = nullptr;  // index of the face that is being refined, if faces have any
};

}  // namespace

void Displace(PlyMesh* mesh, const FloatTexture& displacement, const Transform& renderFromObject,
              float edgeLength, const FileLoc& loc) {
    if (!(edgeLength > 0))
        throw SceneError(loc, fmt::format("displacement needs a positive edge length, found {}", edgeLength));
    if (mesh->vertices.uv.empty())
        throw SceneError(loc, "displacement needs vertices with uv, which this mesh has not");
    SplitQuads(mesh);
    VertexArrays& v = mesh->vertices;
    if (v.n.empty()) v.n = MeanNormals(v.p, mesh->triangles);
    Refiner(mesh, renderFromObject, edgeLength, loc).Run();
    for (size_t i = 0; i < v.p.size(); ++i) {
        TextureContext context;
        context.p = v.p[i];
        context.n = v.n[i];
        context.uv = v.uv[i];
        v.p[i] += displacement.Evaluate(context) * v.n[i];
        if (!std::isfinite(v.p[i].x) || !std::isfinite(v.p[i].y) || !std::isfinite(v.p[i].z))
            throw SceneError(loc, "the displacement of a vertex is not a finite number");
    }
    v.n = MeanNormals(v.p, mesh->triangles);
}

}  // namespace lacquer
