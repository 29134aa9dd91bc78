// Shape "bilinearmesh": bilinear patches with vertices and indices in the scene file.
//
//   "point3 P" []              required  vertices
//   "integer indices" []       one face  4 vertex numbers for each face
//   "normal N" []              -         normals of the vertices
//   "point2 uv" []             -         texture coordinates of the vertices
//   "integer faceIndices" []   -         a number for each face
//   "string emissionfilename"  -         has no effect: points of emitters are sampled by area, with the same
//                                        mean
#include "pbrt/shapes/bilinear_mesh.h"

namespace lacquer {

namespace {

std::vector<std::unique_ptr<Shape>> CreateBilinearMesh(const ShapeArgs& args) {
    // pbrt draws points of image-textured patches by that image; here they are drawn by area, with the same
    // mean.
    args.params.Ignore("string", "emissionfilename");
    MeshParams mesh = GetMeshParams(args.params, 4);
    mesh.vertices.ToRendering(args.renderFromObject, args.reverseOrientation, args.params.LocOf("P"));
    BilinearMesh::Arrays arrays;
    arrays.vertices = std::move(mesh.vertices);
    arrays.faceIndices = std::move(mesh.faceIndices);
    for (size_t i = 0; i < mesh.indices.size(); i += 4)
        arrays.patches.emplace_back(mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2],
                                    mesh.indices[i + 3]);
    std::vector<std::unique_ptr<Shape>> shapes;
    shapes.push_back(std::make_unique<BilinearMesh>(
        std::move(arrays), args.reverseOrientation != args.renderFromObject.SwapsHandedness()));
    return shapes;
}

}  // namespace

LACQUER_REGISTER(ShapeKind, "bilinearmesh", CreateBilinearMesh);

}  // namespace lacquer
