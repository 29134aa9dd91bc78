#include "pbrt/shapes/loop_subdivision.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>

#include "pbrt/core/check.h"

namespace lacquer {

namespace {

using glm::dvec3;

constexpr uint32_t kNone = std::numeric_limits<uint32_t>::max();

// Half-edge 3 t + k runs from corner k of triangle t to the next corner.
uint32_t Next(uint32_t halfEdge) { return halfEdge % 3 == 2 ? halfEdge - 2 : halfEdge + 1; }
uint32_t Previous(uint32_t halfEdge) { return halfEdge % 3 == 0 ? halfEdge + 2 : halfEdge - 1; }
uint32_t Origin(const std::vector<glm::uvec3>& triangles, uint32_t halfEdge) {
    return triangles[halfEdge / 3][glm::length_t(halfEdge % 3)];
}

// For each half-edge the one that runs the other way along the same edge, or kNone on the boundary.
std::optional<EdgeDefect> FindTwins(const std::vector<glm::uvec3>& triangles, std::vector<uint32_t>* twins) {
    // Bring the half-edges of an edge together.
    struct KeyedHalfEdge {
        uint64_t edge;
        uint32_t halfEdge;
        bool operator<(const KeyedHalfEdge& other) const {
            return std::pair(edge, halfEdge) < std::pair(other.edge, other.halfEdge);
        }
    };
    const uint32_t numHalfEdges = uint32_t(3 * triangles.size());
    std::vector<KeyedHalfEdge> sorted(numHalfEdges);
    for (uint32_t h = 0; h < numHalfEdges; ++h) {
        const uint32_t a = Origin(triangles, h), b = Origin(triangles, Next(h));
        sorted[h] = {uint64_t(std::min(a, b)) << 32 | std::max(a, b), h};
    }
    std::sort(sorted.begin(), sorted.end());

    // Join the two of each edge.
    twins->assign(numHalfEdges, kNone);
    for (size_t begin = 0, end = 0; begin < sorted.size(); begin = end) {
        while (end < sorted.size() && sorted[end].edge == sorted[begin].edge) ++end;
        if (end - begin == 1) continue;
        const uint32_t h = sorted[begin].halfEdge, other = sorted[begin + 1].halfEdge;
        const uint32_t from = Origin(triangles, h), to = Origin(triangles, Next(h));
        if (end - begin > 2 || Origin(triangles, other) == from)
            return EdgeDefect{from, to, int(end - begin)};
        (*twins)[h] = other;
        (*twins)[other] = h;
    }
    return std::nullopt;
}

// Triangles in which those around any vertex form one fan, closed or open.
class LoopMesh {
  public:
    LoopMesh(std::span<const Point3> p, std::vector<glm::uvec3> triangles, std::vector<uint32_t> twins);

    LoopMesh Refined() const;
    LimitSurface Limit() &&;

  private:
    LoopMesh() = default;
    uint32_t NumHalfEdges() const { return uint32_t(twins_.size()); }
    uint32_t Origin(uint32_t halfEdge) const { return lacquer::Origin(triangles_, halfEdge); }
    dvec3 OriginPoint(uint32_t halfEdge) const { return dvec3(p_[Origin(halfEdge)]); }
    bool IsBoundary(uint32_t vertex) const { return twins_[first_[vertex]] == kNone; }
    void FindFirstHalfEdges();
    /// visit(p) for the neighbours of a vertex, counterclockwise; on the boundary from border to border.
    template <class Visit>
    void ForEachNeighbour(uint32_t vertex, const Visit& visit) const;

    Point3 RefinedVertex(uint32_t vertex) const;
    Point3 EdgePoint(uint32_t halfEdge) const;
    Point3 LimitPosition(uint32_t vertex) const;
    /// Of a mesh whose vertices are at their limit already; not unit.
    dvec3 LimitNormal(uint32_t vertex) const;

    std::vector<Point3> p_;
    std::vector<glm::uvec3> triangles_;
    std::vector<uint32_t> twins_;
    std::vector<uint32_t> first_;  // a half-edge from each vertex; on the boundary the one without a twin
};

LoopMesh::LoopMesh(std::span<const Point3> p, std::vector<glm::uvec3> triangles, std::vector<uint32_t> twins)
    : triangles_(std::move(triangles)), twins_(std::move(twins)) {
    // Give every fan of triangles a vertex of its own: the vertices in order, and the fans of one likewise.
    std::vector<std::pair<uint32_t, uint32_t>> corners(NumHalfEdges());  // (vertex, half-edge)
    for (uint32_t h = 0; h < NumHalfEdges(); ++h) corners[h] = {Origin(h), h};
    std::sort(corners.begin(), corners.end());
    std::vector<bool> done(NumHalfEdges(), false);
    for (const auto& [vertex, corner] : corners) {
        if (done[corner]) continue;
        // Begin where the fan does, if it is open.
        uint32_t begin = corner;
        while (twins_[begin] != kNone && Next(twins_[begin]) != corner) begin = Next(twins_[begin]);
        for (uint32_t h = begin; h != kNone && !done[h]; h = twins_[Previous(h)]) {
            done[h] = true;
            triangles_[h / 3][glm::length_t(h % 3)] = uint32_t(p_.size());
        }
        p_.push_back(p[vertex]);
    }
    FindFirstHalfEdges();
}

void LoopMesh::FindFirstHalfEdges() {
    first_.assign(p_.size(), kNone);
    for (uint32_t h = 0; h < NumHalfEdges(); ++h) {
        uint32_t& first = first_[Origin(h)];
        if (first == kNone || twins_[h] == kNone) first = h;
    }
}

template <class Visit>
void LoopMesh::ForEachNeighbour(uint32_t vertex, const Visit& visit) const {
    uint32_t h = first_[vertex];
    do {
        visit(OriginPoint(Next(h)));
        const uint32_t before = Previous(h);
        h = twins_[before];
        if (h == kNone) visit(OriginPoint(before));
    } while (h != kNone && h != first_[vertex]);
}

// The neighbours of a vertex, summed: all of them, and the first and last, which on the boundary lie on it.
struct NeighbourSums {
    int num = 0;
    dvec3 sum{0}, first{0}, last{0};
    void operator()(const dvec3& p) {
        if (num++ == 0) first = p;
        sum += p;
        last = p;
    }
};

// Weight of each of the n neighbours of an inner vertex [Warren and Weimer 2001].
double VertexWeight(int n) { return n == 3 ? 3. / 16 : 3 / (8. * n); }

Point3 LoopMesh::RefinedVertex(uint32_t vertex) const {
    NeighbourSums neighbours;
    ForEachNeighbour(vertex, [&](const dvec3& p) { neighbours(p); });
    const dvec3 p(p_[vertex]);
    if (IsBoundary(vertex)) return Point3(0.75 * p + 0.125 * (neighbours.first + neighbours.last));
    const double beta = VertexWeight(neighbours.num);
    return Point3((1 - neighbours.num * beta) * p + beta * neighbours.sum);
}

Point3 LoopMesh::EdgePoint(uint32_t halfEdge) const {
    const dvec3 ends = OriginPoint(halfEdge) + OriginPoint(Next(halfEdge));
    const uint32_t twin = twins_[halfEdge];
    if (twin == kNone) return Point3(0.5 * ends);
    const dvec3 opposite = OriginPoint(Previous(halfEdge)) + OriginPoint(Previous(twin));
    return Point3(0.375 * ends + 0.125 * opposite);
}

LoopMesh LoopMesh::Refined() const {
    // Move the vertices and make one on each edge.
    LoopMesh fine;
    const uint32_t numTriangles = uint32_t(triangles_.size());
    fine.p_.reserve(p_.size() + size_t(NumHalfEdges()) / 2 + 1);
    for (uint32_t v = 0; v < p_.size(); ++v) fine.p_.push_back(RefinedVertex(v));
    std::vector<uint32_t> edgeVertex(NumHalfEdges());
    for (uint32_t h = 0; h < NumHalfEdges(); ++h) {
        const bool seen = twins_[h] < h;
        edgeVertex[h] = seen ? edgeVertex[twins_[h]] : uint32_t(fine.p_.size());
        if (!seen) fine.p_.push_back(EdgePoint(h));
    }

    // Cut each triangle t into one at each corner, 4 t + k, and one between the edge points, 4 t + 3.
    fine.triangles_.resize(size_t(numTriangles) * 4);
    fine.twins_.resize(size_t(numTriangles) * 12);
    for (uint32_t t = 0; t < numTriangles; ++t) {
        const uint32_t middle = 4 * t + 3;
        const uint32_t* e = &edgeVertex[3 * t];
        fine.triangles_[middle] = {e[0], e[1], e[2]};
        for (uint32_t k = 0; k < 3; ++k) {
            const uint32_t h = 3 * t + k, child = 4 * t + k, twin = twins_[h];
            fine.triangles_[child] = {Origin(h), e[k], e[(k + 2) % 3]};
            fine.twins_[3 * child + 1] = 3 * middle + (k + 2) % 3;
            fine.twins_[3 * middle + (k + 2) % 3] = 3 * child + 1;
            // The first half of edge k lies against the second half of its twin, and the other way round.
            const uint32_t firstHalf = 3 * child, secondHalf = 3 * (4 * t + (k + 1) % 3) + 2;
            const uint32_t other = twin == kNone ? 0 : twin / 3, j = twin == kNone ? 0 : twin % 3;
            fine.twins_[firstHalf] = twin == kNone ? kNone : 3 * (4 * other + (j + 1) % 3) + 2;
            fine.twins_[secondHalf] = twin == kNone ? kNone : 3 * (4 * other + j);
        }
    }
    fine.FindFirstHalfEdges();
    return fine;
}

// The left eigenvector of the refinement around a vertex for the eigenvalue 1. On the boundary that of a
// cubic B-spline is (1, 4, 1) / 6; (1, 3, 1) / 5 is what pbrt takes, and so does this.
Point3 LoopMesh::LimitPosition(uint32_t vertex) const {
    NeighbourSums neighbours;
    ForEachNeighbour(vertex, [&](const dvec3& p) { neighbours(p); });
    const dvec3 p(p_[vertex]);
    if (IsBoundary(vertex)) return Point3(0.6 * p + 0.2 * (neighbours.first + neighbours.last));
    const double gamma = 1 / (neighbours.num + 3 / (8 * VertexWeight(neighbours.num)));
    return Point3((1 - neighbours.num * gamma) * p + gamma * neighbours.sum);
}

// Multiples of an angle, by rotation.
struct Rotation {
    explicit Rotation(double angle) : c(std::cos(angle)), s(std::sin(angle)) {}
    void Advance() { std::tie(cosine, sine) = std::pair(c * cosine - s * sine, s * cosine + c * sine); }
    double c, s, cosine = 1, sine = 0;
};

// Tangents of an inner vertex: the first Fourier mode of its ring, seen from the vertex [Hoppe et al. 1994].
template <class ForEach>
std::pair<dvec3, dvec3> InnerTangents(int num, const ForEach& forEach) {
    dvec3 cosines(0), sines(0);
    if (num == 2) return {cosines, sines};  // two triangles back to back
    Rotation angle(2 * double(Pi) / num);
    forEach([&](const dvec3& neighbour) {
        cosines += angle.cosine * neighbour;
        sines += angle.sine * neighbour;
        angle.Advance();
    });
    return {cosines, sines};
}

// Tangents of a boundary vertex from its neighbours, seen from the vertex: against the boundary, and inward
// by the masks of [Hoppe et al. 1994] for two, three, four or more neighbours.
template <class ForEach>
std::pair<dvec3, dvec3> BoundaryTangents(const NeighbourSums& neighbours, const ForEach& forEach) {
    const dvec3 along = neighbours.first - neighbours.last, ends = neighbours.first + neighbours.last;
    const dvec3 inside = neighbours.sum - ends;
    if (neighbours.num == 2) return {along, ends};
    if (neighbours.num == 3) return {along, inside};
    if (neighbours.num == 4) return {along, 2. * inside - ends};
    Rotation angle(double(Pi) / (neighbours.num - 1));
    dvec3 inward = -angle.s * ends;
    int k = 0;
    forEach([&](const dvec3& neighbour) {
        if (k > 0 && k < neighbours.num - 1) inward += (2 - 2 * angle.c) * angle.sine * neighbour;
        angle.Advance();
        ++k;
    });
    return {along, inward};
}

dvec3 LoopMesh::LimitNormal(uint32_t vertex) const {
    const dvec3 center(p_[vertex]);
    const auto forEach = [&](const auto& visit) {
        ForEachNeighbour(vertex, [&](const dvec3& p) { visit(p - center); });
    };
    NeighbourSums neighbours;
    forEach([&](const dvec3& p) { neighbours(p); });
    const auto [x, y] =
        IsBoundary(vertex) ? BoundaryTangents(neighbours, forEach) : InnerTangents(neighbours.num, forEach);
    return glm::cross(y, x);
}

LimitSurface LoopMesh::Limit() && {
    // Move all vertices before any normal is taken.
    std::vector<Point3> limit;
    limit.reserve(p_.size());
    for (uint32_t v = 0; v < p_.size(); ++v) limit.push_back(LimitPosition(v));
    p_ = std::move(limit);

    // Keep the ratios of the normals' lengths, whatever the unit of the positions.
    std::vector<dvec3> normals;
    normals.reserve(p_.size());
    double longest = 0;
    for (uint32_t v = 0; v < p_.size(); ++v) {
        normals.push_back(LimitNormal(v));
        longest = std::max(longest, glm::length(normals.back()));
    }
    LimitSurface surface;
    surface.n.reserve(p_.size());
    for (const dvec3& n : normals) surface.n.push_back(longest > 0 ? Normal3(n / longest) : Normal3(0));
    surface.p = std::move(p_);
    surface.triangles = std::move(triangles_);
    return surface;
}

}  // namespace

std::variant<LimitSurface, EdgeDefect> SubdivideLoop(std::span<const Point3> p,
                                                     std::vector<glm::uvec3> triangles, int levels) {
    LACQUER_CHECK(levels >= 0 && levels < 15 && triangles.size() << (2 * levels) < size_t(1) << 30);
    std::vector<uint32_t> twins;
    if (const std::optional<EdgeDefect> defect = FindTwins(triangles, &twins)) return *defect;
    LoopMesh mesh(p, std::move(triangles), std::move(twins));
    for (int level = 0; level < levels; ++level) mesh = mesh.Refined();
    return std::move(mesh).Limit();
}

}  // namespace lacquer
