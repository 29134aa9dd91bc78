// Which triangles lie side by side: for what goes along a surface and not over all of it.
#pragma once

#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "pbrt/core/vec.h"

namespace lacquer {

/// An edge at which triangles do not form a surface with two sides.
struct EdgeDefect {
    uint32_t from = 0, to = 0;  ///< vertices
    int numTriangles = 0;  ///< that share the edge: more than two, or two that both run from `from` to `to`
};

/// Triangles that form a surface with two sides, with or without boundaries. Half-edge 3 t + k runs from
/// corner k of triangle t to the next corner: counterclockwise, seen from where the triangle is wound so.
struct HalfEdgeMesh {
    static constexpr uint32_t kNone = ~0u;

    std::vector<glm::uvec3> triangles;
    std::vector<uint32_t> opposite;  ///< of each half-edge; kNone on the boundary
    /// Of each vertex, a half-edge that starts there; on the boundary, the one without an opposite.
    std::vector<uint32_t> outgoing;

    static uint32_t Next(uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
    static uint32_t Previous(uint32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }

    size_t NumVertices() const { return outgoing.size(); }
    size_t NumHalfEdges() const { return opposite.size(); }
    uint32_t Origin(uint32_t h) const { return triangles[h / 3][int(h % 3)]; }
    uint32_t Target(uint32_t h) const { return Origin(Next(h)); }
    bool IsOnBoundary(uint32_t vertex) const { return opposite[outgoing[vertex]] == kNone; }
    /// One of the two half-edges of each edge.
    bool StandsForEdge(uint32_t h) const { return opposite[h] == kNone || h < opposite[h]; }

    /// visit(neighbour), counterclockwise: for a vertex on the boundary from one end to the other.
    template <class Visit>
    void VisitRing(uint32_t vertex, const Visit& visit) const {
        const uint32_t first = outgoing[vertex];
        for (uint32_t h = first;;) {
            visit(Target(h));
            const uint32_t arriving = Previous(h);
            h = opposite[arriving];
            if (h == kNone) return visit(Origin(arriving));
            if (h == first) return;
        }
    }
};

/// A mesh, and for each of its vertices the one that it was made from.
struct SeparatedMesh {
    HalfEdgeMesh mesh;
    std::vector<uint32_t> source;
};

/// Finds neighbours. Vertices without a triangle are left out; a vertex at which several fans of triangles
/// merely touch becomes one vertex for each, the first in its place and the others after all given ones.
/// @param triangles  each of three different vertices below numVertices
/// @return  the first defect if there is one
std::variant<SeparatedMesh, EdgeDefect> ConnectTriangles(size_t numVertices,
                                                         std::span<const glm::uvec3> triangles);

/// Cuts each triangle into four at the middles of its edges. Vertices keep their numbers, and those of edges
/// follow. Corners stand in pbrt's order, for the tangents of a mesh without texture coordinates follow it.
/// @param middles  receives that vertex for each half-edge of `coarse`
HalfEdgeMesh Quartered(const HalfEdgeMesh& coarse, std::vector<uint32_t>* middles);

}  // namespace lacquer
