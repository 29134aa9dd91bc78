#include "pbrt/shapes/half_edges.h"

#include <algorithm>
#include <optional>

#include "pbrt/core/parallel.h"

namespace lacquer {

namespace {

constexpr uint32_t kNone = HalfEdgeMesh::kNone;

// Numbers the vertices that triangles use anew, in their order. Returns the old numbers of the new ones.
std::vector<uint32_t> LeaveOutUnusedVertices(size_t numVertices, std::vector<glm::uvec3>* triangles) {
    std::vector<uint32_t> number(numVertices, 0), source;
    for (const glm::uvec3& t : *triangles)
        for (int k = 0; k < 3; ++k) number[t[k]] = 1;
    for (uint32_t v = 0; v < numVertices; ++v) {
        if (number[v] == 0) continue;
        number[v] = uint32_t(source.size());
        source.push_back(v);
    }
    for (glm::uvec3& t : *triangles) t = {number[t.x], number[t.y], number[t.z]};
    return source;
}

// Half-edges in the order of the smaller number of their ends.
class HalfEdgesByVertex {
  public:
    HalfEdgesByVertex(const HalfEdgeMesh& mesh, size_t numVertices)
        : first_(numVertices + 1, 0), sides_(3 * mesh.triangles.size()) {
        const auto smaller = [&](uint32_t h) { return std::min(mesh.Origin(h), mesh.Target(h)); };
        for (uint32_t h = 0; h < sides_.size(); ++h) ++first_[smaller(h) + 1];
        for (size_t v = 0; v < numVertices; ++v) first_[v + 1] += first_[v];
        std::vector<uint32_t> end(first_.begin(), first_.end() - 1);
        for (uint32_t h = 0; h < sides_.size(); ++h)
            sides_[end[smaller(h)]++] = {std::max(mesh.Origin(h), mesh.Target(h)), h};
    }

    /// visit(half-edges of one edge, in their order)
    template <class Visit>
    void VisitEdges(const Visit& visit) {
        std::vector<uint32_t> edge;
        for (size_t v = 0; v + 1 < first_.size(); ++v) {
            const std::span<Side> sides(&sides_[0] + first_[v], first_[v + 1] - first_[v]);
            std::sort(sides.begin(), sides.end());
            for (size_t begin = 0; begin < sides.size(); begin += edge.size()) {
                edge.clear();
                for (size_t i = begin; i < sides.size() && sides[i].other == sides[begin].other; ++i)
                    edge.push_back(sides[i].halfEdge);
                visit(edge);
            }
        }
    }

  private:
    struct Side {
        uint32_t other, halfEdge;
        auto operator<=>(const Side&) const = default;
    };
    std::vector<uint32_t> first_;  // of each vertex, among the sides
    std::vector<Side> sides_;
};

// Sets opposites. Of several defects, returns that of the first triangle.
std::optional<EdgeDefect> FindOpposites(size_t numVertices, HalfEdgeMesh* mesh) {
    mesh->opposite.assign(3 * mesh->triangles.size(), kNone);
    std::optional<EdgeDefect> defect;
    uint32_t first = kNone;
    HalfEdgesByVertex(*mesh, numVertices).VisitEdges([&](const std::vector<uint32_t>& edge) {
        if (edge.size() == 1) return;
        const uint32_t a = edge[0], b = edge[1];
        if (edge.size() > 2 || mesh->Origin(a) == mesh->Origin(b)) {
            if (a > first) return;
            first = a;
            defect = EdgeDefect{mesh->Origin(a), mesh->Target(a), int(edge.size())};
            return;
        }
        mesh->opposite[a] = b;
        mesh->opposite[b] = a;
    });
    return defect;
}

// The half-edge to go around its origin from, so as to meet all triangles of the fan.
uint32_t StartOfFan(const HalfEdgeMesh& mesh, uint32_t h) {
    uint32_t start = h;
    while (mesh.opposite[start] != kNone) {
        start = HalfEdgeMesh::Next(mesh.opposite[start]);
        if (start == h) break;
    }
    return start;
}

// Sets the vertices' half-edges, and gives every fan of triangles a vertex of its own.
void SeparateFans(SeparatedMesh* separated) {
    HalfEdgeMesh& mesh = separated->mesh;
    mesh.outgoing.assign(separated->source.size(), kNone);
    std::vector<bool> isKnown(mesh.NumHalfEdges(), false);
    for (uint32_t corner = 0; corner < isKnown.size(); ++corner) {
        if (isKnown[corner]) continue;
        const uint32_t start = StartOfFan(mesh, corner);
        uint32_t vertex = mesh.Origin(corner);
        if (mesh.outgoing[vertex] != kNone) {
            const uint32_t source = separated->source[vertex];
            vertex = uint32_t(mesh.outgoing.size());
            separated->source.push_back(source);
            mesh.outgoing.push_back(kNone);
        }
        mesh.outgoing[vertex] = start;
        for (uint32_t h = start; h != kNone && !isKnown[h]; h = mesh.opposite[HalfEdgeMesh::Previous(h)]) {
            isKnown[h] = true;
            mesh.triangles[h / 3][int(h % 3)] = vertex;
        }
    }
}

// Of the four triangles of each one, number k < 3 keeps its corner k, and the last is the inner one. These
// are the halves of a half-edge that start at its origin and at its middle.
uint32_t FirstHalf(uint32_t h) { return 3 * (4 * (h / 3) + h % 3) + h % 3; }
uint32_t SecondHalf(uint32_t h) { return 3 * (4 * (h / 3) + (h + 1) % 3) + h % 3; }

// Numbers the edges, from `first` on: for each half-edge that of its edge. Returns the end of the numbers.
uint32_t NumberEdges(const HalfEdgeMesh& mesh, uint32_t first, std::vector<uint32_t>* numbers) {
    numbers->resize(mesh.NumHalfEdges());
    for (uint32_t h = 0; h < numbers->size(); ++h)
        (*numbers)[h] = mesh.StandsForEdge(h) ? first++ : (*numbers)[mesh.opposite[h]];
    return first;
}

void QuarterTriangle(const HalfEdgeMesh& coarse, const std::vector<uint32_t>& middles, uint32_t triangle,
                     HalfEdgeMesh* fine) {
    const uint32_t first = 3 * triangle, inner = 4 * triangle + 3;
    const glm::uvec3 v = coarse.triangles[triangle],
                     m(middles[first], middles[first + 1], middles[first + 2]);
    fine->triangles[4 * triangle] = {v[0], m[0], m[2]};
    fine->triangles[4 * triangle + 1] = {m[0], v[1], m[1]};
    fine->triangles[4 * triangle + 2] = {m[2], m[1], v[2]};
    fine->triangles[inner] = m;
    for (uint32_t k = 0; k < 3; ++k) {
        const uint32_t h = first + k, across = coarse.opposite[h];
        fine->opposite[FirstHalf(h)] = across == kNone ? kNone : SecondHalf(across);
        fine->opposite[SecondHalf(h)] = across == kNone ? kNone : FirstHalf(across);
        // The side of corner k's triangle that the inner one shares.
        const uint32_t side = 3 * (4 * triangle + k) + (k + 1) % 3, sideOfInner = 3 * inner + (k + 2) % 3;
        fine->opposite[side] = sideOfInner;
        fine->opposite[sideOfInner] = side;
    }
}

}  // namespace

std::variant<SeparatedMesh, EdgeDefect> ConnectTriangles(size_t numVertices,
                                                         std::span<const glm::uvec3> triangles) {
    SeparatedMesh separated;
    separated.mesh.triangles.assign(triangles.begin(), triangles.end());
    separated.source = LeaveOutUnusedVertices(numVertices, &separated.mesh.triangles);
    if (auto defect = FindOpposites(separated.source.size(), &separated.mesh)) {
        defect->from = separated.source[defect->from];
        defect->to = separated.source[defect->to];
        return *defect;
    }
    SeparateFans(&separated);
    return separated;
}

HalfEdgeMesh Quartered(const HalfEdgeMesh& coarse, std::vector<uint32_t>* middles) {
    HalfEdgeMesh fine;
    fine.triangles.resize(4 * coarse.triangles.size());
    fine.opposite.resize(4 * coarse.NumHalfEdges());
    fine.outgoing.resize(NumberEdges(coarse, uint32_t(coarse.NumVertices()), middles));
    ParallelFor(int64_t(coarse.triangles.size()),
                [&](int64_t t) { QuarterTriangle(coarse, *middles, uint32_t(t), &fine); });
    ParallelFor(int64_t(coarse.NumVertices()),
                [&](int64_t v) { fine.outgoing[size_t(v)] = FirstHalf(coarse.outgoing[size_t(v)]); });
    ParallelFor(int64_t(coarse.NumHalfEdges()), [&](int64_t h) {
        if (coarse.StandsForEdge(uint32_t(h))) fine.outgoing[(*middles)[size_t(h)]] = SecondHalf(uint32_t(h));
    });
    return fine;
}

}  // namespace lacquer
