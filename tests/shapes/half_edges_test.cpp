#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "pbrt/core/rng.h"
#include "pbrt/shapes/half_edges.h"

namespace lacquer::test::half_edges_test {

namespace {

using Triangles = std::vector<glm::uvec3>;

SeparatedMesh Connect(size_t numVertices, const Triangles& triangles) {
    auto result = ConnectTriangles(numVertices, triangles);
    EXPECT_TRUE(std::holds_alternative<SeparatedMesh>(result));
    return std::get<SeparatedMesh>(std::move(result));
}

// A strip of squares, each cut in two; joined at its ends or not.
Triangles Strip(uint32_t size, bool closed) {
    Triangles triangles;
    for (uint32_t i = 0; i < size; ++i) {
        const uint32_t a = 2 * i, b = closed ? 2 * ((i + 1) % size) : 2 * (i + 1);
        triangles.emplace_back(a, b, b + 1);
        triangles.emplace_back(a, b + 1, a + 1);
    }
    return triangles;
}

// What the half-edges say, against what the triangles say when all are looked at.
void ExpectConsistent(const HalfEdgeMesh& mesh) {
    std::map<std::pair<uint32_t, uint32_t>, uint32_t> halfEdges;
    std::vector<std::set<uint32_t>> neighbours(mesh.NumVertices());
    for (uint32_t h = 0; h < mesh.NumHalfEdges(); ++h) {
        EXPECT_TRUE(halfEdges.emplace(std::pair(mesh.Origin(h), mesh.Target(h)), h).second);
        neighbours[mesh.Origin(h)].insert(mesh.Target(h));
        neighbours[mesh.Target(h)].insert(mesh.Origin(h));
    }
    for (const auto& [ends, h] : halfEdges) {
        const auto found = halfEdges.find(std::pair(ends.second, ends.first));
        EXPECT_EQ(mesh.opposite[h], found == halfEdges.end() ? HalfEdgeMesh::kNone : found->second);
    }
    for (uint32_t v = 0; v < mesh.NumVertices(); ++v) {
        EXPECT_EQ(mesh.Origin(mesh.outgoing[v]), v);
        std::vector<uint32_t> ring;
        mesh.VisitRing(v, [&](uint32_t neighbour) { ring.push_back(neighbour); });
        EXPECT_EQ(ring.size(), neighbours[v].size()) << v;
        EXPECT_EQ(std::set<uint32_t>(ring.begin(), ring.end()), neighbours[v]) << v;
        // Counterclockwise: each neighbour and the next are a side across from the vertex.
        const size_t numSides = mesh.IsOnBoundary(v) ? ring.size() - 1 : ring.size();
        for (size_t i = 0; i < numSides; ++i)
            EXPECT_TRUE(halfEdges.contains({ring[i], ring[(i + 1) % ring.size()]})) << v;
    }
}

}  // namespace

TEST(HalfEdges, NeighboursAreThoseOfTheTriangles) {
    const Triangles tetrahedron{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
    // Two triangles back to back, of which quarters would have several edges between the same vertices.
    ExpectConsistent(Connect(3, {{0, 1, 2}, {2, 1, 0}}).mesh);
    for (const Triangles& triangles : {tetrahedron, Strip(1, false), Strip(5, false), Strip(4, true)}) {
        HalfEdgeMesh mesh = Connect(20, triangles).mesh;
        ExpectConsistent(mesh);
        for (int level = 0; level < 3; ++level) {
            std::vector<uint32_t> middles;
            const HalfEdgeMesh fine = Quartered(mesh, &middles);
            EXPECT_EQ(fine.triangles.size(), 4 * mesh.triangles.size());
            ExpectConsistent(fine);
            // An edge has one middle, whatever its half-edges, and old vertices are where they were.
            EXPECT_EQ(std::set<uint32_t>(middles.begin(), middles.end()).size(),
                      fine.NumVertices() - mesh.NumVertices());
            for (uint32_t h = 0; h < mesh.NumHalfEdges(); ++h) {
                const uint32_t t = h / 3, k = h % 3;
                EXPECT_EQ(fine.triangles[4 * t + k][int(k)], mesh.Origin(h));
                EXPECT_EQ(fine.triangles[4 * t + 3][int(k)], middles[h]);
                EXPECT_GE(middles[h], mesh.NumVertices());
            }
            mesh = fine;
        }
    }
}

TEST(HalfEdges, OrderAndCornersOfTrianglesDoNotMatter) {
    Rng rng(3);
    Triangles triangles = Strip(7, true);
    for (int i = 0; i < 50; ++i) {
        for (size_t t = triangles.size() - 1; t > 0; --t)
            std::swap(triangles[t], triangles[size_t(rng.Uniform() * float(t))]);
        for (glm::uvec3& t : triangles)
            if (rng.Uniform() < 0.5f) t = {t.y, t.z, t.x};
        const SeparatedMesh separated = Connect(14, triangles);
        EXPECT_EQ(separated.mesh.NumVertices(), 14u);
        ExpectConsistent(separated.mesh);
    }
}

TEST(HalfEdges, FansThatTouchGetVerticesOfTheirOwn) {
    // Three triangles around a vertex that share no edges, and a closed fan at the same vertex.
    Triangles triangles{{9, 1, 2}, {9, 3, 4}, {5, 6, 9}};
    for (uint32_t i = 0; i < 3; ++i) triangles.emplace_back(10 + i, 10 + (i + 1) % 3, 9);
    const SeparatedMesh separated = Connect(13, triangles);
    ExpectConsistent(separated.mesh);
    std::vector<uint32_t> middles;
    ExpectConsistent(Quartered(separated.mesh, &middles));
    // Vertices 1 to 6, 9 and 10 to 12 are used, and three more stand where 9 is.
    const std::vector<uint32_t> expected{1, 2, 3, 4, 5, 6, 9, 10, 11, 12, 9, 9, 9};
    EXPECT_EQ(separated.source, expected);
}

TEST(HalfEdges, TheFirstDefectIsTold) {
    const auto defectOf = [](const Triangles& triangles) {
        const auto result = ConnectTriangles(30, triangles);
        EXPECT_TRUE(std::holds_alternative<EdgeDefect>(result));
        return std::get<EdgeDefect>(result);
    };
    // Vertex 0 is not used. The later edge of the lower numbers is another defect.
    const EdgeDefect fin = defectOf({{20, 21, 22}, {21, 20, 23}, {20, 21, 24}, {1, 2, 3}, {1, 2, 4}});
    EXPECT_EQ(std::pair(fin.from, fin.to), std::pair(20u, 21u));
    EXPECT_EQ(fin.numTriangles, 3);
    const EdgeDefect turned = defectOf({{1, 2, 3}, {1, 2, 4}});
    EXPECT_EQ(std::pair(turned.from, turned.to), std::pair(1u, 2u));
    EXPECT_EQ(turned.numTriangles, 2);
}

}  // namespace lacquer::test::half_edges_test
