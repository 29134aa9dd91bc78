#include "pbrt/shapes/loop_subdivision.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "pbrt/core/check.h"
#include "pbrt/core/parallel.h"

namespace lacquer {

namespace {

using glm::dvec2;
using glm::dvec3;

// In double precision, so that positions and normals are rounded once.
using Points = std::vector<dvec3>;

// What the neighbours of an inner vertex weigh together where it is refined: 3/16 each for three of them,
// else 3 / (8 n) each for n [Warren and Weimer 2001].
double WeightOfRing(size_t numNeighbours) { return numNeighbours == 3 ? 9. / 16 : 3. / 8; }

// The same for the limit: the left eigenvector for the eigenvalue 1 of the refinement around a vertex has the
// weight 1 / (n + 3 / (8 beta)) for each of n neighbours, if beta is theirs in the refinement.
double LimitWeightOfRing(size_t numNeighbours) { return numNeighbours == 3 ? 3. / 5 : 1. / 2; }

// A boundary is a uniform cubic B-spline: what its two neighbours weigh together.
constexpr double kWeightOfEnds = 1. / 4, kLimitWeightOfEnds = 1. / 3;

struct Ring {
    dvec3 sum{0}, ends{0};  // of all neighbours; of the first and the last
    size_t size = 0;
};

Ring RingOf(const HalfEdgeMesh& mesh, const Points& p, uint32_t vertex) {
    Ring ring;
    dvec3 last(0);
    mesh.VisitRing(vertex, [&](uint32_t neighbour) {
        last = p[neighbour];
        if (ring.size++ == 0) ring.ends = last;
        ring.sum += last;
    });
    ring.ends += last;
    return ring;
}

// A vertex between itself and its neighbours.
dvec3 Weighed(dvec3 p, const Ring& ring, bool isOnBoundary, double weightOfEnds, double weightOfRing) {
    if (isOnBoundary) return (1 - weightOfEnds) * p + weightOfEnds / 2 * ring.ends;
    return (1 - weightOfRing) * p + weightOfRing / double(ring.size) * ring.sum;
}

dvec3 MiddleOf(const HalfEdgeMesh& mesh, const Points& p, uint32_t h) {
    const dvec3 ends = p[mesh.Origin(h)] + p[mesh.Target(h)];
    const uint32_t across = mesh.opposite[h];
    if (across == HalfEdgeMesh::kNone) return ends / 2.;
    const auto corner = [&](uint32_t side) { return p[mesh.Origin(HalfEdgeMesh::Previous(side))]; };
    return (3. * ends + corner(h) + corner(across)) / 8.;
}

void Refine(HalfEdgeMesh* mesh, Points* p) {
    std::vector<uint32_t> middles;
    HalfEdgeMesh fine = Quartered(*mesh, &middles);
    Points refined(fine.NumVertices());
    ParallelFor(int64_t(mesh->NumVertices()), [&](int64_t i) {
        const uint32_t v = uint32_t(i);
        const Ring ring = RingOf(*mesh, *p, v);
        refined[v] = Weighed((*p)[v], ring, mesh->IsOnBoundary(v), kWeightOfEnds, WeightOfRing(ring.size));
    });
    ParallelFor(int64_t(mesh->NumHalfEdges()), [&](int64_t i) {
        const uint32_t h = uint32_t(i);
        if (mesh->StandsForEdge(h)) refined[middles[h]] = MiddleOf(*mesh, *p, h);
    });
    *mesh = std::move(fine);
    *p = std::move(refined);
}

// What neighbour number k weighs in the two tangents of a vertex, from the first of which the ring turns
// counterclockwise to the second; and the vertex itself. Eigenvectors of the refinement around a vertex,
// whose limits they give.
struct TangentWeights {
    std::vector<dvec2> neighbours;
    dvec2 self{0};
};

TangentWeights InnerTangents(size_t numNeighbours) {
    TangentWeights weights{std::vector<dvec2>(numNeighbours, dvec2(0))};
    // Two triangles back to back have no tangent plane, but for rounding.
    if (numNeighbours == 2) return weights;
    for (size_t k = 0; k < numNeighbours; ++k) {
        const double angle = 2 * std::numbers::pi * double(k) / double(numNeighbours);
        weights.neighbours[k] = {std::cos(angle), std::sin(angle)};
    }
    return weights;
}

// Length of the tangent across a boundary, over that of weights sin(k theta): as in pbrt, which has those of
// [Hoppe et al. 1994, table 1].
double ScaleAcross(size_t numNeighbours, double theta) {
    switch (numNeighbours) {
        case 2:
        case 3:
            return 1;
        case 4:
            return 2 / std::sin(theta);
        default:
            return 2 - 2 * std::cos(theta);
    }
}

// Along the boundary and across it. Across, a neighbour inside must weigh w with
//   lambda w[k] = 3/8 w[k] + (w[k-1] + w[k+1]) / 8,
// where those at the ends count for nothing, as they stay on the boundary: w[k] = sin(k theta) for
// lambda = 3/8 + cos(theta) / 4. The end itself goes to its own middle, the next one's and the vertex:
//   lambda w[0] = w[0] / 2 + (w[1] + self) / 8,
// and all weights sum to zero. [Hoppe et al. 1994] have these but for five neighbours and more, where theirs
// are of another rule for edges. Of a vertex between two others alone the only such weights are (1, 1, -2).
TangentWeights BoundaryTangents(size_t numNeighbours) {
    TangentWeights weights{std::vector<dvec2>(numNeighbours, dvec2(0))};
    std::vector<dvec2>& w = weights.neighbours;
    const double theta = std::numbers::pi / double(numNeighbours - 1),
                 scale = ScaleAcross(numNeighbours, theta);
    double sum = 0;
    for (size_t k = 1; k + 1 < numNeighbours; ++k) sum += w[k].y = scale * std::sin(double(k) * theta);
    const double end = numNeighbours == 2 ? 1 : (w[1].y - sum) / (1 + 2 * std::cos(theta));
    w.front() = {1, end};
    w.back() = {-1, end};
    weights.self.y = -sum - 2 * end;
    return weights;
}

// Moves a mesh to its limit.
class Limit {
  public:
    /// @param numControl  first vertices, which may have any number of neighbours: others have six, or four
    /// on the boundary
    Limit(const HalfEdgeMesh& mesh, const Points& p, size_t numControl)
        : mesh_(mesh),
          p_(p),
          numControl_(numControl),
          regularInside_(InnerTangents(6)),
          regularOnBoundary_(BoundaryTangents(4)) {}

    void Find(LimitSurface* surface) const {
        const size_t count = mesh_.NumVertices();
        surface->p.resize(count);
        Points normals(count);
        ParallelFor(int64_t(count), [&](int64_t i) {
            const uint32_t v = uint32_t(i);
            const Ring ring = RingOf(mesh_, p_, v);
            const bool isOnBoundary = mesh_.IsOnBoundary(v);
            surface->p[v] =
                Point3(Weighed(p_[v], ring, isOnBoundary, kLimitWeightOfEnds, LimitWeightOfRing(ring.size)));
            normals[v] = NormalAt(v, ring.size, isOnBoundary);
        });
        surface->n = InProportion(normals);
    }

  private:
    dvec3 NormalAt(uint32_t v, size_t numNeighbours, bool isOnBoundary) const {
        if (v >= numControl_) return NormalAcross(v, isOnBoundary ? regularOnBoundary_ : regularInside_);
        return NormalAcross(v, isOnBoundary ? BoundaryTangents(numNeighbours) : InnerTangents(numNeighbours));
    }
    dvec3 NormalAcross(uint32_t v, const TangentWeights& weights) const {
        dvec3 tangent1 = weights.self.x * p_[v], tangent2 = weights.self.y * p_[v];
        const dvec2* weight = weights.neighbours.data();
        mesh_.VisitRing(v, [&](uint32_t neighbour) {
            tangent1 += weight->x * p_[neighbour];
            tangent2 += weight->y * p_[neighbour];
            ++weight;
        });
        return glm::cross(tangent2, tangent1);
    }
    // Whatever the unit of the positions.
    static std::vector<Normal3> InProportion(const Points& normals) {
        double longest = 0;
        for (const dvec3& n : normals) longest = std::max(longest, glm::dot(n, n));
        std::vector<Normal3> result(normals.size(), Normal3(0));
        if (longest > 0)
            for (size_t v = 0; v < result.size(); ++v) result[v] = Normal3(normals[v] / std::sqrt(longest));
        return result;
    }

    const HalfEdgeMesh& mesh_;
    const Points& p_;
    size_t numControl_;
    TangentWeights regularInside_, regularOnBoundary_;
};

}  // namespace

std::variant<LimitSurface, EdgeDefect> SubdivideLoop(std::span<const Point3> p,
                                                     std::span<const glm::uvec3> triangles, int levels) {
    LACQUER_CHECK(levels >= 0 && levels < 15 && triangles.size() << (2 * levels) < size_t(1) << 30);
    auto connected = ConnectTriangles(p.size(), triangles);
    if (const auto* defect = std::get_if<EdgeDefect>(&connected)) return *defect;
    auto& [mesh, source] = std::get<SeparatedMesh>(connected);
    Points points(source.size());
    for (size_t v = 0; v < points.size(); ++v) points[v] = dvec3(p[source[v]]);
    for (int level = 0; level < levels; ++level) Refine(&mesh, &points);

    LimitSurface surface;
    Limit(mesh, points, source.size()).Find(&surface);
    surface.triangles = std::move(mesh.triangles);
    return surface;
}

}  // namespace lacquer
