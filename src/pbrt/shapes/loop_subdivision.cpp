#include "pbrt/shapes/loop_subdivision.h"

#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "pbrt/core/check.h"

namespace lacquer {

namespace {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;
using glm::dvec3;

// Triangles and the vertices that they use.
struct ControlMesh {
    std::vector<Point3> p;
    std::vector<uint32_t> source;  // of each vertex, its number in the mesh that was given
    std::vector<glm::uvec3> triangles;
};

ControlMesh WithoutUnusedVertices(std::span<const Point3> p, std::span<const glm::uvec3> triangles) {
    std::vector<bool> used(p.size(), false);
    for (const glm::uvec3& t : triangles)
        for (int k = 0; k < 3; ++k) used[t[k]] = true;
    ControlMesh mesh;
    std::vector<uint32_t> number(p.size());
    for (uint32_t v = 0; v < p.size(); ++v) {
        number[v] = uint32_t(mesh.p.size());
        if (!used[v]) continue;
        mesh.p.push_back(p[v]);
        mesh.source.push_back(v);
    }
    mesh.triangles.reserve(triangles.size());
    for (const glm::uvec3& t : triangles) mesh.triangles.emplace_back(number[t.x], number[t.y], number[t.z]);
    return mesh;
}

std::optional<HighValenceVertex> FindHighValenceVertex(const ControlMesh& mesh) {
    std::vector<int> numTriangles(mesh.p.size(), 0);
    for (const glm::uvec3& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) ++numTriangles[t[k]];
    for (size_t v = 0; v < mesh.p.size(); ++v)
        if (numTriangles[v] > HighValenceVertex::kMaxTriangles)
            return HighValenceVertex{mesh.source[v], numTriangles[v]};
    return std::nullopt;
}

std::unique_ptr<Far::TopologyRefiner> MakeRefiner(const ControlMesh& mesh) {
    const std::vector<int> numVertices(mesh.triangles.size(), 3);
    Far::TopologyDescriptor topology;
    topology.numVertices = int(mesh.p.size());
    topology.numFaces = int(mesh.triangles.size());
    topology.numVertsPerFace = numVertices.data();
    topology.vertIndicesPerFace = reinterpret_cast<const int*>(mesh.triangles.data());
    // Boundaries are creases, and vertices of one triangle no corners: they are rounded like the others.
    Sdc::Options options;
    options.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    std::unique_ptr<Far::TopologyRefiner> refiner(
        Factory::Create(topology, Factory::Options(Sdc::SCHEME_LOOP, options)));
    LACQUER_CHECK(refiner != nullptr);
    return refiner;
}

// OpenSubdiv refines such edges too, by rules of its own. pbrt does not, and the surface has no sides there.
std::optional<EdgeDefect> FindEdgeDefect(const Far::TopologyLevel& level, const ControlMesh& mesh) {
    for (int edge = 0; edge < level.GetNumEdges(); ++edge) {
        if (!level.IsEdgeNonManifold(edge)) continue;
        // Name the ends in the order in which the first triangle has them.
        const Far::ConstIndexArray ends = level.GetEdgeVertices(edge), faces = level.GetEdgeFaces(edge);
        const glm::uvec3& t = mesh.triangles[size_t(faces[0])];
        uint32_t from = uint32_t(ends[0]), to = uint32_t(ends[1]);
        for (int k = 0; k < 3; ++k)
            if (t[k] == to && t[(k + 1) % 3] == from) {
                std::swap(from, to);
                break;
            }
        return EdgeDefect{mesh.source[from], mesh.source[to], faces.size()};
    }
    return std::nullopt;
}

// Finds the triangles that are joined to one of a vertex by edges of that vertex. Marks them with it.
std::vector<int> FanOf(const Far::TopologyLevel& level, int vertex, int face, std::vector<int>* mark) {
    std::vector<int> fan = {face};
    (*mark)[size_t(face)] = vertex;
    for (size_t i = 0; i < fan.size(); ++i)
        for (const int edge : level.GetFaceEdges(fan[i])) {
            const Far::ConstIndexArray ends = level.GetEdgeVertices(edge);
            if (ends[0] != vertex && ends[1] != vertex) continue;
            for (const int next : level.GetEdgeFaces(edge))
                if (std::exchange((*mark)[size_t(next)], vertex) != vertex) fan.push_back(next);
        }
    return fan;
}

// Gives every fan of triangles a vertex of its own. Tells whether there was anything to do.
bool SplitNonManifoldVertices(const Far::TopologyLevel& level, ControlMesh* mesh) {
    const size_t numBefore = mesh->p.size();
    std::vector<int> mark(mesh->triangles.size(), -1);
    for (int vertex = 0; vertex < level.GetNumVertices(); ++vertex) {
        if (!level.IsVertexNonManifold(vertex)) continue;
        bool first = true;
        for (const int face : level.GetVertexFaces(vertex)) {
            if (mark[size_t(face)] == vertex) continue;
            const std::vector<int> fan = FanOf(level, vertex, face, &mark);
            if (std::exchange(first, false)) continue;
            for (const int other : fan) {
                glm::uvec3& t = mesh->triangles[size_t(other)];
                for (int k = 0; k < 3; ++k)
                    if (t[k] == uint32_t(vertex)) t[k] = uint32_t(mesh->p.size());
            }
            const Point3 p = mesh->p[size_t(vertex)];
            mesh->p.push_back(p);
        }
    }
    return mesh->p.size() > numBefore;
}

// What OpenSubdiv sums up: a point or a tangent.
struct WeightedSum {
    dvec3 v{0};
    void Clear() { v = dvec3(0); }
    void AddWithWeight(const WeightedSum& other, double weight) { v += weight * other.v; }
};
using WeightedSums = std::vector<WeightedSum>;

// Inner vertices that are not of the valences 3 and 6. OpenSubdiv takes Loop's own weights for them, pbrt
// those of [Warren and Weimer 2001]: 3 / (8 n) for each of n neighbours, where refinement makes a vertex. All
// else is alike in both, and each level only adds inner vertices of valence 6.
class IrregularVertices {
  public:
    explicit IrregularVertices(const Far::TopologyLevel& control) {
        for (int v = 0; v < control.GetNumVertices(); ++v) {
            const int valence = control.GetVertexEdges(v).size();
            if (!control.IsVertexBoundary(v) && valence != 3 && valence != 6) vertices_.push_back(v);
        }
    }

    void Refine(const Far::TopologyLevel& level, const WeightedSums& p, WeightedSums* refined) const {
        for (const int v : vertices_) Weigh(level, p, v, 3. / 8, refined);
    }

    // The left eigenvector for the eigenvalue 1 of the refinement around a vertex has the weight
    // 1 / (n + 3 / (8 beta)) for each of n neighbours, if beta is theirs in the refinement: 1 / (2 n).
    void MoveToLimit(const Far::TopologyLevel& level, const WeightedSums& p, WeightedSums* limit,
                     WeightedSums* tangent) const {
        for (const int v : vertices_) {
            Weigh(level, p, v, 1. / 2, limit);
            // Two triangles back to back have no tangent plane there, but for rounding.
            if (level.GetVertexEdges(v).size() == 2) (*tangent)[size_t(v)].Clear();
        }
    }

  private:
    // A vertex keeps its number through all levels.
    static void Weigh(const Far::TopologyLevel& level, const WeightedSums& p, int vertex,
                      double weightOfNeighbours, WeightedSums* result) {
        const Far::ConstIndexArray edges = level.GetVertexEdges(vertex);
        WeightedSum& sum = (*result)[size_t(vertex)];
        sum.Clear();
        for (const int edge : edges) {
            const Far::ConstIndexArray ends = level.GetEdgeVertices(edge);
            const int neighbour = ends[0] == vertex ? ends[1] : ends[0];
            sum.AddWithWeight(p[size_t(neighbour)], weightOfNeighbours / edges.size());
        }
        sum.AddWithWeight(p[size_t(vertex)], 1 - weightOfNeighbours);
    }

    std::vector<int> vertices_;
};

void Refine(Far::TopologyRefiner* refiner, int levels) {
    Far::TopologyRefiner::UniformOptions options(levels);
    options.orderVerticesFromFacesFirst = false;  // those of vertices come first
    options.fullTopologyInLastLevel = true;       // limits need the neighbours
    refiner->RefineUniform(options);
}

std::vector<glm::uvec3> Triangles(const Far::TopologyLevel& level) {
    std::vector<glm::uvec3> triangles(size_t(level.GetNumFaces()));
    for (int face = 0; face < level.GetNumFaces(); ++face) {
        const Far::ConstIndexArray v = level.GetFaceVertices(face);
        triangles[size_t(face)] = {v[0], v[1], v[2]};
    }
    return triangles;
}

// Normals in proportion to those across the tangents, whatever the unit of the positions.
std::vector<Normal3> NormalsAcross(const WeightedSums& tangents1, const WeightedSums& tangents2) {
    const auto normal = [&](size_t i) { return glm::cross(tangents2[i].v, tangents1[i].v); };
    double longest = 0;
    for (size_t i = 0; i < tangents1.size(); ++i) longest = std::max(longest, glm::length(normal(i)));
    std::vector<Normal3> normals(tangents1.size(), Normal3(0));
    if (longest > 0)
        for (size_t i = 0; i < normals.size(); ++i) normals[i] = Normal3(normal(i) / longest);
    return normals;
}

LimitSurface Limit(const std::vector<Point3>& control, std::unique_ptr<Far::TopologyRefiner> refiner) {
    const int levels = refiner->GetMaxLevel();
    const IrregularVertices irregular(refiner->GetLevel(0));
    const Far::PrimvarRefinerReal<double> weights(*refiner);

    // Refine the positions level by level.
    WeightedSums p(control.size());
    for (size_t v = 0; v < p.size(); ++v) p[v].v = dvec3(control[v]);
    for (int level = 1; level <= levels; ++level) {
        WeightedSums refined(size_t(refiner->GetLevel(level).GetNumVertices()));
        weights.Interpolate(level, p, refined);
        irregular.Refine(refiner->GetLevel(level - 1), p, &refined);
        p = std::move(refined);
    }

    // Move them to their limit.
    WeightedSums limit(p.size()), tangents1(p.size()), tangents2(p.size());
    weights.Limit(p, limit, tangents1, tangents2);
    irregular.MoveToLimit(refiner->GetLevel(levels), p, &limit, &tangents2);

    // Keep no more than what was asked for: the refiner is far larger.
    LimitSurface surface;
    surface.triangles = Triangles(refiner->GetLevel(levels));
    refiner.reset();
    surface.p.reserve(limit.size());
    for (const WeightedSum& sum : limit) surface.p.emplace_back(sum.v);
    surface.n = NormalsAcross(tangents1, tangents2);
    return surface;
}

}  // namespace

std::variant<LimitSurface, EdgeDefect, HighValenceVertex> SubdivideLoop(std::span<const Point3> p,
                                                                        std::span<const glm::uvec3> triangles,
                                                                        int levels) {
    LACQUER_CHECK(levels >= 0 && levels < 15 && triangles.size() << (2 * levels) < size_t(1) << 30);
    ControlMesh mesh = WithoutUnusedVertices(p, triangles);
    if (const auto defect = FindHighValenceVertex(mesh)) return *defect;
    std::unique_ptr<Far::TopologyRefiner> refiner = MakeRefiner(mesh);
    if (const auto defect = FindEdgeDefect(refiner->GetLevel(0), mesh)) return *defect;
    if (SplitNonManifoldVertices(refiner->GetLevel(0), &mesh)) refiner = MakeRefiner(mesh);
    Refine(refiner.get(), levels);
    return Limit(mesh.p, std::move(refiner));
}

}  // namespace lacquer
