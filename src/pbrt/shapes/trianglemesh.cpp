// Shape "trianglemesh": triangles with vertices and indices in the scene file.
//
//   "point3 P" []             required  vertices
//   "integer indices" []      one face  3 vertex numbers for each face
//   "normal N" []             -         normals of the vertices
//   "vector3 S" []            -         tangents of the vertices
//   "point2 uv" []            -         texture coordinates of the vertices
//   "integer faceIndices" []  -         a number for each face
#include "pbrt/shapes/triangle_mesh.h"

namespace lacquer {

namespace {

std::vector<std::unique_ptr<Shape>> CreateTriangleMesh(const ShapeArgs& args) {
    MeshParams mesh = GetMeshParams(args.params, 3);
    mesh.vertices.ToRendering(args.renderFromObject, args.reverseOrientation, args.params.LocOf("P"));
    TriangleMesh::Arrays arrays;
    arrays.vertices = std::move(mesh.vertices);
    arrays.faceIndices = std::move(mesh.faceIndices);
    for (size_t i = 0; i < mesh.indices.size(); i += 3)
        arrays.triangles.emplace_back(mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]);
    std::vector<std::unique_ptr<Shape>> shapes;
    shapes.push_back(std::make_unique<TriangleMesh>(
        std::move(arrays), args.reverseOrientation != args.renderFromObject.SwapsHandedness()));
    return shapes;
}

}  // namespace

LACQUER_REGISTER(ShapeKind, "trianglemesh", CreateTriangleMesh);

}  // namespace lacquer
