// Loop's subdivision surfaces, apart from any scene: triangles in, triangles on the limit surface out.
#pragma once

#include <span>
#include <variant>
#include <vector>

#include "pbrt/shapes/half_edges.h"

namespace lacquer {

/// Vertices on a subdivision surface, in the order: those of the control mesh, then those of each level.
struct LimitSurface {
    std::vector<Point3> p;
    /// Normals of the surface, one a vertex, across its tangents. They point to the side from which the
    /// triangles are seen clockwise, against the cross product (p1 - p0) x (p2 - p0). Not unit: in proportion
    /// to the area around the vertex (the longest has length 1), which is their weight where they are
    /// interpolated, as in pbrt. Zero without a tangent plane.
    std::vector<Normal3> n;
    std::vector<glm::uvec3> triangles;  ///< wound as the control triangles
};

/// Refines a mesh `levels` times by Loop's scheme with the weights of [Warren and Weimer 2001] and puts the
/// vertices where endless refinement would take them. Edges of one triangle only are creases that stay
/// curves: uniform cubic B-splines. Vertices without a triangle are left out; a vertex at which several fans
/// of triangles merely touch becomes one vertex for each, the first in its place and the others after all
/// control vertices.
/// @param p          finite
/// @param triangles  in range, each of three different vertices
/// @param levels     >= 0; the result has 4^levels triangles for each one and must have less than 2^30
/// @return  the surface, or the first defect if there is one. Time and memory are in proportion to it: some
///          90 bytes a triangle while it is made, for the most part by all threads.
std::variant<LimitSurface, EdgeDefect> SubdivideLoop(std::span<const Point3> p,
                                                     std::span<const glm::uvec3> triangles, int levels);

}  // namespace lacquer
