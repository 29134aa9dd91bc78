// Shape "loopsubdiv": the limit surface of Loop's subdivision of a triangle mesh.
//
//   "point3 P" []         required  control vertices
//   "integer indices" []  required  three vertex numbers for each triangle
//   "integer levels"      3         of refinement, before the vertices move to the limit surface
//   "string scheme"       -         has no effect
#include <fmt/format.h>

#include "pbrt/core/progress.h"
#include "pbrt/shapes/loop_subdivision.h"
#include "pbrt/shapes/triangle_mesh.h"

namespace lacquer {

namespace {

constexpr size_t kMaxTriangles = size_t(1) << 25;

std::vector<Point3> GetVertices(const Params& params) {
    std::vector<Point3> p = params.GetPoint3s("P");
    if (p.empty()) params.Fail("P", "loopsubdiv needs its vertices: \"point3 P\" is expected");
    for (size_t i = 0; i < p.size(); ++i)
        if (!IsFinite(p[i]))
            params.Fail("P", fmt::format("element {} of \"P\" is not finite; numbers are expected", i));
    return p;
}

// The control triangles; those that name a vertex twice have no surface between their edges and are left out.
std::vector<glm::uvec3> GetControlTriangles(const ShapeArgs& args, size_t numVertices) {
    const Params& params = args.params;
    const std::vector<int> indices = params.GetInts("indices");
    if (indices.empty())
        params.Fail("indices", "loopsubdiv needs its triangles: \"integer indices\" is expected");
    if (indices.size() % 3 != 0)
        params.Fail("indices",
                    fmt::format("\"indices\" has {} elements; a multiple of 3 is expected", indices.size()));
    for (size_t i = 0; i < indices.size(); ++i)
        if (indices[i] < 0 || size_t(indices[i]) >= numVertices)
            params.Fail("indices",
                        fmt::format("element {} of \"indices\" is {}; a vertex number in [0, {}] is expected",
                                    i, indices[i], numVertices - 1));

    std::vector<glm::uvec3> triangles;
    for (size_t i = 0; i < indices.size(); i += 3) {
        const glm::uvec3 v(indices[i], indices[i + 1], indices[i + 2]);
        if (v.x != v.y && v.y != v.z && v.z != v.x) triangles.push_back(v);
    }
    if (triangles.empty())
        params.Fail("indices",
                    "every triangle of \"indices\" names a vertex twice; three different ones "
                    "are expected");
    const size_t numDropped = indices.size() / 3 - triangles.size();
    if (numDropped > 0 && args.observer)
        args.observer->Warn(fmt::format("{}: warning: {} triangles that name a vertex twice are left out",
                                        params.LocOf("indices").ToString(), numDropped));
    return triangles;
}

int GetLevels(const Params& params, size_t numTriangles) {
    const int levels = params.GetInt("levels", 3);
    int max = 0;
    while (numTriangles << (2 * (max + 1)) <= kMaxTriangles) ++max;
    if (levels < 0 || levels > max)
        params.Fail("levels",
                    fmt::format("\"levels\" is {}; for {} triangles an integer in [0, {}] is expected",
                                levels, numTriangles, max));
    return levels;
}

[[noreturn]] void FailAt(const EdgeDefect& edge, const Params& params) {
    if (edge.numTriangles > 2)
        params.Fail(
            "indices",
            fmt::format("{} triangles share the edge between vertices {} and {}; at most two are expected",
                        edge.numTriangles, edge.from, edge.to));
    params.Fail(
        "indices",
        fmt::format("two triangles share the edge between vertices {} and {} and both run from {} to {}; "
                    "triangles that are wound in the same sense are expected",
                    edge.from, edge.to, edge.from, edge.to));
}

std::vector<std::unique_ptr<Shape>> CreateLoopSubdiv(const ShapeArgs& args) {
    const Params& params = args.params;
    params.Ignore("string", "scheme");
    const std::vector<Point3> p = GetVertices(params);
    const std::vector<glm::uvec3> triangles = GetControlTriangles(args, p.size());
    auto result = SubdivideLoop(p, triangles, GetLevels(params, triangles.size()));
    if (const auto* edge = std::get_if<EdgeDefect>(&result)) FailAt(*edge, params);

    LimitSurface& surface = std::get<LimitSurface>(result);
    TriangleMesh::Arrays arrays;
    arrays.vertices.p = std::move(surface.p);
    arrays.vertices.n = std::move(surface.n);
    arrays.triangles = std::move(surface.triangles);
    arrays.vertices.ToRendering(args.renderFromObject, args.reverseOrientation, params.LocOf("P"));
    std::vector<std::unique_ptr<Shape>> shapes;
    shapes.push_back(std::make_unique<TriangleMesh>(
        std::move(arrays), args.reverseOrientation != args.renderFromObject.SwapsHandedness()));
    return shapes;
}

}  // namespace

LACQUER_REGISTER(ShapeKind, "loopsubdiv", CreateLoopSubdiv);

}  // namespace lacquer
