// Shape "plymesh": triangles and quads from a PLY file; quads become bilinear patches.
//
//   "string filename"             required  ASCII or binary, perhaps gzipped
//   "float texture displacement"  -         moves the vertices of the refined mesh along their normals
//   "float edgelength"            1         length below which the edges of a displaced mesh are refined
#include <fmt/format.h>

#include "pbrt/core/progress.h"
#include "pbrt/shapes/bilinear_mesh.h"
#include "pbrt/shapes/displacement.h"
#include "pbrt/shapes/mesh_cache.h"
#include "pbrt/shapes/ply_reader.h"
#include "pbrt/shapes/triangle_mesh.h"

namespace lacquer {

namespace {

// The vertices that `faces` use, in order of first use; the faces are renumbered. So neither of the two
// meshes of a mixed file holds what only the other one needs.
template <class Face>
VertexArrays Extract(const VertexArrays& all, std::vector<Face>* faces) {
    constexpr uint32_t kUnused = 0xffffffffu;
    std::vector<uint32_t> renumbered(all.p.size(), kUnused);
    VertexArrays used;
    for (Face& face : *faces)
        for (int k = 0; k < Face::length(); ++k) {
            const uint32_t old = face[k];
            if (renumbered[old] == kUnused) {
                renumbered[old] = uint32_t(used.p.size());
                used.p.push_back(all.p[old]);
                if (!all.n.empty()) used.n.push_back(all.n[old]);
                if (!all.uv.empty()) used.uv.push_back(all.uv[old]);
            }
            face[k] = renumbered[old];
        }
    used.p.shrink_to_fit();
    used.n.shrink_to_fit();
    used.uv.shrink_to_fit();
    return used;
}

std::unique_ptr<Shape> MakePatches(PlyMesh* ply, VertexArrays vertices, bool flip) {
    BilinearMesh::Arrays arrays;
    arrays.vertices = std::move(vertices);
    arrays.patches = std::move(ply->quads);
    arrays.faceIndices = std::move(ply->quadFaceIndices);
    // PLY goes around the face; patches are stored row by row.
    for (glm::uvec4& v : arrays.patches) std::swap(v.z, v.w);
    arrays.patches.shrink_to_fit();
    return std::make_unique<BilinearMesh>(std::move(arrays), flip);
}

std::unique_ptr<Shape> MakeTriangles(PlyMesh* ply, VertexArrays vertices, bool flip) {
    TriangleMesh::Arrays arrays;
    arrays.vertices = std::move(vertices);
    arrays.triangles = std::move(ply->triangles);
    arrays.faceIndices = std::move(ply->triangleFaceIndices);
    return std::make_unique<TriangleMesh>(std::move(arrays), flip);
}

std::vector<std::unique_ptr<Shape>> CreatePlyMesh(const ShapeArgs& args) {
    const Params& params = args.params;
    const FileLoc loc = params.LocOf("filename");
    const std::optional<std::string> filename = params.GetOptionalString("filename");
    if (!filename || filename->empty())
        params.Fail("filename", "plymesh needs the name of its file: \"string filename\" is expected");
    const FloatTexture* displacement = OptionalFloatTextureParam(params, "displacement", args.textures);
    const float edgeLength = params.GetFloat("edgelength", 1);

    const std::string path = params.PathOf("filename");
    PlyMesh ply = args.meshes ? *args.meshes->Get(path, loc) : ReadPly(path, loc);
    if (ply.numIgnoredFaces > 0 && args.observer)
        args.observer->Warn(fmt::format("{}: warning: {}: {} faces with neither 3 nor 4 corners are left out",
                                        loc.ToString(), *filename, ply.numIgnoredFaces));
    if (ply.triangles.empty() && ply.quads.empty()) return {};
    ply.vertices.DropNonFinite(*filename, loc, args.observer);
    if (displacement)
        Displace(&ply, *displacement, args.renderFromObject, edgeLength * args.displacementEdgeScale,
                 params.LocOf("displacement"));
    ply.vertices.ToRendering(args.renderFromObject, args.reverseOrientation, loc);
    const bool flip = args.reverseOrientation != args.renderFromObject.SwapsHandedness();
    const bool mixed = !ply.triangles.empty() && !ply.quads.empty();
    std::vector<std::unique_ptr<Shape>> shapes;
    if (!ply.quads.empty()) {
        VertexArrays vertices = mixed ? Extract(ply.vertices, &ply.quads) : std::move(ply.vertices);
        shapes.push_back(MakePatches(&ply, std::move(vertices), flip));
    }
    if (!ply.triangles.empty()) {
        VertexArrays vertices = mixed ? Extract(ply.vertices, &ply.triangles) : std::move(ply.vertices);
        shapes.push_back(MakeTriangles(&ply, std::move(vertices), flip));
    }
    return shapes;
}

}  // namespace

LACQUER_REGISTER(ShapeKind, "plymesh", CreatePlyMesh);

}  // namespace lacquer
