#include <fmt/format.h>
#include <gtest/gtest.h>

#include <atomic>
#include <map>
#include <set>

#include "pbrt/core/parallel.h"
#include "pbrt/core/rng.h"
#include "pbrt/shapes/loop_subdivision.h"
#include "shapes/shape_test_support.h"

namespace lacquer::test::loopsubdiv_test {

namespace {

using Triangles = std::vector<glm::uvec3>;

struct ControlMesh {
    std::vector<Point3> p;
    Triangles triangles;
};

LimitSurface Subdivide(const ControlMesh& mesh, int levels) {
    auto result = SubdivideLoop(mesh.p, mesh.triangles, levels);
    EXPECT_TRUE(std::holds_alternative<LimitSurface>(result));
    return std::get<LimitSurface>(std::move(result));
}

// Wound counterclockwise as seen from outside, as are the others.
const ControlMesh kTetrahedron{{{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}},
                               {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}}};
const ControlMesh kOctahedron{
    {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}},
    {{0, 1, 2}, {1, 3, 2}, {3, 4, 2}, {4, 0, 2}, {1, 0, 5}, {3, 1, 5}, {4, 3, 5}, {0, 4, 5}}};

// size x size squares of side 1, each cut along the same diagonal, counterclockwise as seen from +z.
ControlMesh Grid(uint32_t size) {
    ControlMesh mesh;
    for (uint32_t y = 0; y <= size; ++y)
        for (uint32_t x = 0; x <= size; ++x) mesh.p.emplace_back(x, y, 0);
    for (uint32_t y = 0; y < size; ++y)
        for (uint32_t x = 0; x < size; ++x) {
            const uint32_t v = y * (size + 1) + x;
            mesh.triangles.emplace_back(v, v + 1, v + size + 2);
            mesh.triangles.emplace_back(v, v + size + 2, v + size + 1);
        }
    return mesh;
}

// A vertex at the origin amid `num` others on a circle; open fans span less than the whole circle.
ControlMesh Fan(uint32_t num, bool closed) {
    ControlMesh mesh;
    mesh.p.emplace_back(0);
    for (uint32_t i = 0; i < num; ++i) {
        const float angle = 2 * Pi * float(i) / float(closed ? num : num + 1);
        mesh.p.emplace_back(std::cos(angle), std::sin(angle), 0);
    }
    for (uint32_t i = 0; i + (closed ? 0 : 1) < num; ++i)
        mesh.triangles.emplace_back(0, 1 + i, 1 + (i + 1) % num);
    return mesh;
}

void Displace(ControlMesh* mesh, float size) {
    Rng rng(1);
    // Braces are evaluated in their order: the same mesh by every compiler.
    for (Point3& p : mesh->p) p += size * (2.f * Vec3{rng.Uniform(), rng.Uniform(), rng.Uniform()} - 1.f);
}

// Each edge at most twice, and then in both directions.
void ExpectManifold(const LimitSurface& surface) {
    std::set<std::pair<uint32_t, uint32_t>> directed;
    for (const glm::uvec3& t : surface.triangles)
        for (int k = 0; k < 3; ++k) EXPECT_TRUE(directed.emplace(t[k], t[(k + 1) % 3]).second);
}

void ExpectNear(Vec3 a, Vec3 b, float tolerance, const std::string& where) {
    EXPECT_LE(Length(a - b), tolerance)
        << where << fmt::format(": ({} {} {}) and ({} {} {})", a.x, a.y, a.z, b.x, b.y, b.z);
}

ShapeSetup SetupOf(const ControlMesh& mesh, int levels) {
    std::vector<float> p;
    for (const Point3& v : mesh.p) p.insert(p.end(), {v.x, v.y, v.z});
    std::vector<int> indices;
    for (const glm::uvec3& t : mesh.triangles) indices.insert(indices.end(), {int(t.x), int(t.y), int(t.z)});
    return {
        .name = "loopsubdiv",
        .parameters = {Integers("levels", {levels}), Floats("point3", "P", p), Integers("indices", indices)}};
}

std::string ErrorOfMesh(const ControlMesh& mesh, int levels = 1) { return ErrorOf(SetupOf(mesh, levels)); }

}  // namespace

TEST(LoopSubdivision, CountsFollowEulersFormula) {
    for (int levels = 0; levels <= 4; ++levels) {
        const LimitSurface surface = Subdivide(kTetrahedron, levels);
        EXPECT_EQ(surface.triangles.size(), size_t(4) << (2 * levels));
        // Closed and without holes: V = 2 + F / 2.
        EXPECT_EQ(surface.p.size(), 2 + surface.triangles.size() / 2);
        EXPECT_EQ(surface.n.size(), surface.p.size());
        ExpectManifold(surface);
    }
    const LimitSurface grid = Subdivide(Grid(3), 2);
    EXPECT_EQ(grid.p.size(), size_t(13 * 13));
    ExpectManifold(grid);
}

TEST(LoopSubdivision, OctahedronVertexHasTheClosedForm) {
    // Valence 4: half the vertex and half the mean of its ring, which is the centre.
    const LimitSurface surface = Subdivide(kOctahedron, 0);
    for (size_t i = 0; i < kOctahedron.p.size(); ++i) {
        ExpectNear(surface.p[i], 0.5f * kOctahedron.p[i], 1e-6f, fmt::format("vertex {}", i));
        ExpectNear(Normalize(surface.n[i]), -kOctahedron.p[i], 1e-6f, fmt::format("normal {}", i));
    }
}

TEST(LoopSubdivision, ValenceThreeVertexHasTheClosedForm) {
    // 2/5 of the vertex and 1/5 of each neighbour; the four of a tetrahedron sum to zero: (2/5 - 1/5) p.
    const LimitSurface surface = Subdivide(kTetrahedron, 0);
    for (size_t i = 0; i < kTetrahedron.p.size(); ++i) {
        ExpectNear(surface.p[i], 0.2f * kTetrahedron.p[i], 1e-6f, fmt::format("vertex {}", i));
        ExpectNear(Normalize(surface.n[i]), -Normalize(kTetrahedron.p[i]), 1e-6f,
                   fmt::format("normal {}", i));
    }
}

TEST(LoopSubdivision, InnerVertexOfAnyValenceHasTheClosedForm) {
    // A vertex above its ring: of valence 3 it keeps 2/5 of its height, of any other one half, however often
    // it is refined. Loop's own weights would keep 0.44 of it at valence 4 and 0.47 at valence 5.
    for (uint32_t n = 3; n <= 12; ++n) {
        ControlMesh mesh = Fan(n, true);
        mesh.p[0].z = 1;
        for (int levels : {0, 1, 3})
            EXPECT_NEAR(Subdivide(mesh, levels).p[0].z, n == 3 ? 0.4f : 0.5f, 1e-6f) << n << " " << levels;
    }
}

TEST(LoopSubdivision, BoundaryIsACubicBSpline) {
    // The limits of its vertices are (1, 4, 1) / 6, and those of the points between them (1, 23, 23, 1) / 48,
    // whatever the valence.
    ControlMesh mesh = Grid(3);
    Displace(&mesh, 0.3f);
    const std::vector<uint32_t> loop = {0, 1, 2, 3, 7, 11, 15, 14, 13, 12, 8, 4};
    const LimitSurface surface = Subdivide(mesh, 1);
    const auto distanceToSurface = [&](Point3 p) {
        float nearest = Infinity;
        for (const Point3& q : surface.p) nearest = std::min(nearest, Length(p - q));
        return nearest;
    };
    for (size_t i = 0; i < loop.size(); ++i) {
        const auto p = [&](size_t j) { return mesh.p[loop[(i + j) % loop.size()]]; };
        ExpectNear(surface.p[loop[(i + 1) % loop.size()]], (p(0) + 4.f * p(1) + p(2)) / 6.f, 1e-6f, "vertex");
        EXPECT_LT(distanceToSurface((p(0) + 23.f * p(1) + 23.f * p(2) + p(3)) / 48.f), 1e-6f) << i;
        // The control: none lies in the middle of an edge.
        EXPECT_GT(distanceToSurface((p(1) + p(2)) / 2.f), 1e-3f) << i;
    }
}

TEST(LoopSubdivision, OneRefinementOfTheOctahedronHasTheClosedForm) {
    // Before the limit: vertices 5/8 p; edge points 3/8 (a + b) + 1/8 (c - c). The limit of a vertex moves on
    // half way to the mean of its ring of edge points, 3/8 p: 5/16 + 3/16 = 1/2, as at level 0.
    const LimitSurface surface = Subdivide(kOctahedron, 1);
    for (size_t i = 0; i < 6; ++i)
        ExpectNear(surface.p[i], 0.5f * kOctahedron.p[i], 1e-6f, fmt::format("vertex {}", i));
    // An edge point between a and b (valence 6, weight 1/2) has the neighbours 5/8 a, 5/8 b and four edge
    // points 3/8 (a +- c), 3/8 (b +- c), which sum to 11/8 (a + b): 3/16 (a + b) + 11/96 (a + b) = 29/96 (a +
    // b).
    for (size_t i = 6; i < surface.p.size(); ++i)
        EXPECT_NEAR(Length(surface.p[i]), 29.f / 96 * std::sqrt(2.f), 1e-6f);
}

TEST(LoopSubdivision, PlanarMeshesStayPlanarWithExactNormals) {
    std::vector<ControlMesh> meshes = {Grid(4)};
    for (uint32_t n = 3; n <= 9; ++n) meshes.push_back(Fan(n, true));
    for (uint32_t n = 2; n <= 9; ++n) meshes.push_back(Fan(n, false));
    for (size_t i = 0; i < meshes.size(); ++i)
        for (int levels : {0, 1, 3}) {
            const LimitSurface surface = Subdivide(meshes[i], levels);
            for (size_t v = 0; v < surface.p.size(); ++v) {
                EXPECT_EQ(surface.p[v].z, 0);
                ExpectNear(Normalize(surface.n[v]), Vec3(0, 0, -1), 1e-6f,
                           fmt::format("mesh {} vertex {}", i, v));
            }
        }
}

TEST(LoopSubdivision, RegularGridReproducesLinearFunctions) {
    // Away from the boundary every mask is symmetric with sum 1, so that a regular grid stays where it is.
    const uint32_t size = 8;
    ControlMesh mesh = Grid(size);
    for (Point3& p : mesh.p) p.z = 2 * p.x - 3 * p.y + 1;
    const Normal3 normal = -Normalize(Vec3(-2, 3, 1));
    for (int levels : {0, 2}) {
        const LimitSurface surface = Subdivide(mesh, levels);
        for (uint32_t v = 0; v < mesh.p.size(); ++v) {
            const uint32_t x = v % (size + 1), y = v / (size + 1);
            if (x < 3 || x > 5 || y < 3 || y > 5) continue;
            ExpectNear(surface.p[v], mesh.p[v], 1e-5f, "vertex");
            ExpectNear(Normalize(surface.n[v]), normal, 1e-6f, "normal");
        }
        for (const Point3& p : surface.p) EXPECT_NEAR(p.z, 2 * p.x - 3 * p.y + 1, 1e-5f);
    }
}

TEST(LoopSubdivision, LimitDoesNotDependOnTheLevel) {
    // The limit masks are left eigenvectors of the refinement: a wrong weight anywhere breaks this. Old
    // vertices keep their numbers. All is summed in double precision and rounded once, by some 1e-7.
    std::vector<ControlMesh> meshes = {kTetrahedron, kOctahedron, Grid(4)};
    for (uint32_t n = 3; n <= 9; ++n) meshes.push_back(Fan(n, true));
    for (uint32_t n = 2; n <= 12; ++n) meshes.push_back(Fan(n, false));
    for (size_t i = 0; i < meshes.size(); ++i) {
        Displace(&meshes[i], 0.2f);
        const LimitSurface coarse = Subdivide(meshes[i], 0), fine = Subdivide(meshes[i], 3);
        for (uint32_t v = 0; v < meshes[i].p.size(); ++v) {
            const std::string where = fmt::format("mesh {} vertex {}", i, v);
            ExpectNear(coarse.p[v], fine.p[v], 1e-6f, where);
            EXPECT_LT(AngleBetween(Normalize(coarse.n[v]), Normalize(fine.n[v])), 1e-5f) << where;
        }
    }
}

TEST(LoopSubdivision, NormalsAreAsLongAsThoseOfPbrt) {
    // Cross products of pbrt's tangents on a plane grid: inside, 3 x (2 sqrt(3)); on an edge, (2, 0) x (2,
    // 4); at corners of three neighbours, (1, -1) x (1, 1), and of two, (1, 1) x (-1, 1).
    const LimitSurface surface = Subdivide(Grid(4), 0);
    const float inside = 6 * std::sqrt(3.f);
    EXPECT_NEAR(Length(surface.n[12]), 1, 1e-6f);
    EXPECT_NEAR(Length(surface.n[2]), 8 / inside, 1e-6f);
    EXPECT_NEAR(Length(surface.n[0]), 2 / inside, 1e-6f);
    EXPECT_NEAR(Length(surface.n[4]), 2 / inside, 1e-6f);
}

TEST(LoopSubdivision, NormalsOfCrowdedBoundariesHaveAClosedForm) {
    // Five neighbours on a half circle: (2, 0) x (0, 2 (2 - sqrt(2))), against a vertex at the end of the
    // fan, (1, 1) / sqrt(2) x ((1, 1) / sqrt(2) - (2, 0)).
    ControlMesh mesh;
    mesh.p.emplace_back(0);
    for (uint32_t k = 0; k < 5; ++k) {
        const float angle = Pi / 4 * float(k);
        mesh.p.emplace_back(std::cos(angle), std::sin(angle), 0);
        if (k > 0) mesh.triangles.emplace_back(0, k, k + 1);
    }
    const LimitSurface surface = Subdivide(mesh, 0);
    const float root = std::sqrt(2.f);
    EXPECT_NEAR(Length(surface.n[0]) / Length(surface.n[1]), 4 * (2 - root) / root, 1e-5f);
}

TEST(LoopSubdivision, ManySmallMeshesAreMadeAtTheSameTime) {
    // Loops inside of a loop: their number once decided how long each took.
    std::atomic<size_t> numTriangles = 0;
    ParallelFor(20000, [&](int64_t) { numTriangles += Subdivide(kTetrahedron, 1).triangles.size(); });
    EXPECT_EQ(numTriangles, size_t(20000 * 16));
}

TEST(LoopSubdivision, NormalsDoNotDependOnTheUnit) {
    ControlMesh tiny = kTetrahedron, huge = kTetrahedron;
    for (Point3& p : tiny.p) p *= 0x1p-80f;
    for (Point3& p : huge.p) p *= 0x1p80f;
    const LimitSurface surface = Subdivide(kTetrahedron, 2);
    EXPECT_EQ(Subdivide(tiny, 2).n, surface.n);
    EXPECT_EQ(Subdivide(huge, 2).n, surface.n);
}

TEST(LoopSubdivision, NormalsAreThoseOfTheRefinedTriangles) {
    // The faces around a vertex of an even finer mesh approach the tangent plane in proportion to their size,
    // 1/64.
    ControlMesh mesh = kOctahedron;
    Displace(&mesh, 0.2f);
    const LimitSurface surface = Subdivide(mesh, 6);
    for (const glm::uvec3& t : surface.triangles) {
        const Vec3 face = Normalize(Cross(surface.p[t.y] - surface.p[t.x], surface.p[t.z] - surface.p[t.x]));
        for (int k = 0; k < 3; ++k) EXPECT_LT(Dot(face, Normalize(surface.n[t[k]])), -0.98f);
    }
}

TEST(LoopSubdivision, StraightBoundariesStayStraight) {
    ControlMesh mesh = Grid(4);
    for (size_t v = 0; v < mesh.p.size(); ++v) mesh.p[v].z = mesh.p[v].y * float(v % 3);  // flat along y = 0
    const LimitSurface surface = Subdivide(mesh, 3);
    int numOnEdge = 0;
    for (const Point3& p : surface.p) {
        EXPECT_GE(p.y, 0);
        if (p.y > 0) continue;
        ++numOnEdge;
        EXPECT_EQ(p.z, 0);
    }
    // Rounding the corners takes one control edge at each end: cubic B-splines reach over two. Two of four
    // edges remain, with eight segments each.
    EXPECT_EQ(numOnEdge, 17);
}

TEST(LoopSubdivision, BoundaryDoesNotDependOnTheInside) {
    ControlMesh mesh = Grid(4);
    const LimitSurface flat = Subdivide(mesh, 2);
    for (Point3& p : mesh.p)
        if (p.x > 0 && p.x < 4 && p.y > 0 && p.y < 4) p.z = 5;
    const LimitSurface raised = Subdivide(mesh, 2);
    std::map<std::pair<uint32_t, uint32_t>, int> edges;
    for (const glm::uvec3& t : raised.triangles)
        for (int k = 0; k < 3; ++k) ++edges[std::minmax(t[k], t[(k + 1) % 3])];
    int numBoundary = 0;
    for (const auto& [edge, count] : edges)
        if (count == 1) {
            ++numBoundary;
            EXPECT_EQ(raised.p[edge.first], flat.p[edge.first]);
        }
    EXPECT_EQ(numBoundary, 4 * 4 * 4);
}

TEST(LoopSubdivision, OctahedronOnceRefinedOntoTheSphereIsNearlyASphere) {
    // A finer control mesh of a sphere gives a rounder surface: the spread of the radii falls from the
    // octahedron (limit radii 1/2 and below) to its refinement with all vertices on the sphere.
    const auto spread = [](const LimitSurface& surface) {
        float low = Infinity, high = 0;
        for (const Point3& p : surface.p) {
            low = std::min(low, Length(p));
            high = std::max(high, Length(p));
        }
        return high / low - 1;
    };
    ControlMesh mesh = kOctahedron;
    float previous = spread(Subdivide(mesh, 4));
    for (int i = 0; i < 3; ++i) {
        const LimitSurface once = Subdivide(mesh, 1);
        mesh.p = once.p;
        mesh.triangles = once.triangles;
        for (Point3& p : mesh.p) p = Normalize(p);
        const LimitSurface surface = Subdivide(mesh, 2);
        const float now = spread(surface);
        EXPECT_LT(now, 0.6f * previous) << i;
        previous = now;
        // Normals point inward, against the radius.
        for (size_t v = 0; v < surface.p.size(); ++v)
            EXPECT_LT(Dot(Normalize(surface.n[v]), Normalize(surface.p[v])), i == 0 ? -0.97f : -0.99f);
    }
    EXPECT_LT(previous, 0.02f);
}

TEST(LoopSubdivision, UnusedVerticesAreLeftOut) {
    ControlMesh mesh = kOctahedron;
    mesh.p.insert(mesh.p.begin(), Point3(1e30f));
    mesh.p.emplace_back(-1e30f);
    for (glm::uvec3& t : mesh.triangles) t += 1u;
    const LimitSurface a = Subdivide(mesh, 2), b = Subdivide(kOctahedron, 2);
    EXPECT_EQ(a.p, b.p);
    EXPECT_EQ(a.n, b.n);
    EXPECT_EQ(a.triangles, b.triangles);
}

TEST(LoopSubdivision, FansThatTouchAtAVertexArePartedThere) {
    // Two tetrahedra with one vertex in common become what they are apart.
    ControlMesh mesh = kTetrahedron;
    const Vec3 shift = mesh.p[0] - mesh.p[1];
    for (int i : {0, 2, 3}) mesh.p.push_back(kTetrahedron.p[size_t(i)] + shift);
    const auto renumbered = [](uint32_t v) { return v == 1 ? 0u : v == 0 ? 4u : v + 3; };
    for (const glm::uvec3& t : kTetrahedron.triangles)
        mesh.triangles.emplace_back(renumbered(t.x), renumbered(t.y), renumbered(t.z));
    const LimitSurface both = Subdivide(mesh, 2), one = Subdivide(kTetrahedron, 2);
    ASSERT_EQ(both.p.size(), 2 * one.p.size());
    const auto sum = [](const LimitSurface& s) {
        Vec3 total(0);
        for (const Point3& p : s.p) total += p;
        return total;
    };
    ExpectNear(sum(both), 2.f * sum(one) + float(one.p.size()) * shift, 1e-3f, "sum");
    ExpectManifold(both);
}

TEST(LoopSubdivision, DefectsNameTheEdge) {
    // A fin on an edge, and a triangle turned over.
    ControlMesh fin = Grid(1);
    fin.p.emplace_back(0, 0, 1);
    fin.triangles.emplace_back(3, 0, 4);
    auto result = SubdivideLoop(fin.p, fin.triangles, 1);
    ASSERT_TRUE(std::holds_alternative<EdgeDefect>(result));
    EdgeDefect defect = std::get<EdgeDefect>(result);
    EXPECT_EQ(defect.numTriangles, 3);
    EXPECT_EQ(std::min(defect.from, defect.to), 0u);
    EXPECT_EQ(std::max(defect.from, defect.to), 3u);

    ControlMesh turned = Grid(1);
    std::swap(turned.triangles[1].x, turned.triangles[1].y);
    result = SubdivideLoop(turned.p, turned.triangles, 1);
    ASSERT_TRUE(std::holds_alternative<EdgeDefect>(result));
    defect = std::get<EdgeDefect>(result);
    EXPECT_EQ(defect.numTriangles, 2);
    EXPECT_EQ(std::pair(defect.from, defect.to), std::pair(3u, 0u));
}

TEST(LoopSubdivision, VerticesMayBeCrowded) {
    ControlMesh mesh = Fan(100000, true);
    mesh.p[0].z = 1;
    const LimitSurface surface = Subdivide(mesh, 1);
    EXPECT_EQ(surface.triangles.size(), size_t(400000));
    ExpectNear(surface.p[0], Point3(0, 0, 0.5f), 1e-6f, "centre");
    ExpectNear(Normalize(surface.n[0]), Vec3(0, 0, -1), 1e-6f, "normal");
}

TEST(LoopSubdivision, DegenerateGeometryStaysFinite) {
    ControlMesh point = kOctahedron, line = Grid(2), huge = kTetrahedron;
    for (Point3& p : point.p) p = Point3(1, 2, 3);
    for (Point3& p : line.p) p = Point3(p.x, 0, 0);
    for (Point3& p : huge.p) p *= 3e38f;
    const ControlMesh pillow{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {2, 1, 0}}};
    for (const ControlMesh& mesh : {point, line, huge, pillow}) {
        const LimitSurface surface = Subdivide(mesh, 3);
        for (size_t v = 0; v < surface.p.size(); ++v) {
            EXPECT_TRUE(IsFinite(surface.p[v]));
            EXPECT_TRUE(IsFinite(surface.n[v]));
        }
    }
}

TEST(LoopSubdiv, NormalsPointAgainstTheWindingUnlessReversed) {
    // Rays from outside the octahedron see a normal that points inward, with or without mirroring.
    const Transform mirror = Transform::Scale({-1, 1, 1});
    for (const bool reverse : {false, true})
        for (const bool mirrored : {false, true}) {
            ShapeSetup setup = SetupOf(kOctahedron, 3);
            setup.reverseOrientation = reverse;
            if (mirrored) setup.renderFromObject = mirror;
            const std::unique_ptr<Shape> shape = MakeShape(setup);
            const Ray ray{{0.31f, 0.2f, 5}, {0, 0, -1}};
            const NearestHit hit = IntersectAll(*shape, ray);
            ASSERT_GE(hit.primitive, 0);
            SurfaceInteraction si;
            shape->Interaction(ray, hit.hit, hit.primitive, &si);
            const float sign = reverse ? 1.f : -1.f;
            EXPECT_GT(sign * si.n.z, 0.1f) << reverse << mirrored;
            EXPECT_GT(sign * si.shading.n.z, 0.1f) << reverse << mirrored;
            // The shading normal is smooth, the geometric one that of a facet.
            EXPECT_GT(Dot(si.n, si.shading.n), 0.99f);
            EXPECT_NE(si.n, si.shading.n);
        }
}

TEST(LoopSubdiv, LevelsAreThreeByDefaultAndSchemeIsIgnored) {
    ShapeSetup setup = SetupOf(kTetrahedron, 0);
    EXPECT_EQ(MakeShape(setup)->NumPrimitives(), 4);
    setup.parameters.erase(setup.parameters.begin());
    setup.parameters.push_back(Strings("string", "scheme", {"anything"}));
    EXPECT_EQ(MakeShape(setup)->NumPrimitives(), 4 * 64);
}

TEST(LoopSubdiv, TrianglesThatNameAVertexTwiceAreLeftOutWithAWarning) {
    struct Warnings : Observer {
        void Warn(const std::string& message) override { text += message; }
        std::string text;
    } warnings;
    ControlMesh mesh = kTetrahedron;
    mesh.triangles.emplace_back(2, 2, 1);
    ShapeSetup setup = SetupOf(mesh, 1);
    setup.observer = &warnings;
    EXPECT_EQ(MakeShape(setup)->NumPrimitives(), 16);
    EXPECT_NE(warnings.text.find("1 triangles that name a vertex twice are left out"), std::string::npos)
        << warnings.text;
}

TEST(LoopSubdiv, ErrorsSayWhatIsExpected) {
    const auto expectError = [](const std::string& error, const std::string& part) {
        EXPECT_NE(error.find(part), std::string::npos) << "got: " << error << "\nexpected: " << part;
    };
    ControlMesh mesh = kTetrahedron;
    expectError(ErrorOfMesh({{}, mesh.triangles}), "\"point3 P\" is expected");
    expectError(ErrorOfMesh({mesh.p, {}}), "\"integer indices\" is expected");
    expectError(ErrorOfMesh({mesh.p, {{0, 1, 4}}}),
                "element 2 of \"indices\" is 4; a vertex number in [0, 3]");
    expectError(ErrorOfMesh({mesh.p, {{0, 1, ~0u}}}), "element 2 of \"indices\" is -1");
    expectError(ErrorOfMesh({mesh.p, {{0, 1, 1}}}), "three different ones are expected");
    expectError(ErrorOfMesh(mesh, -1), "\"levels\" is -1; for 4 triangles an integer in [0, 11] is expected");
    expectError(ErrorOfMesh(mesh, 14), "\"levels\" is 14");
    expectError(ErrorOfMesh(mesh, 2147483647), "\"levels\" is 2147483647");
    for (const float bad : {NAN, Infinity}) {
        ControlMesh broken = mesh;
        broken.p[2].y = bad;
        expectError(ErrorOfMesh(broken), "(number 8 of 12)");
    }
    ShapeSetup odd = SetupOf(mesh, 1);
    odd.parameters.back().integers.pop_back();
    expectError(ErrorOf(odd), "\"indices\" has 11 elements; a multiple of 3 is expected");

    ControlMesh fin = mesh;
    fin.p.emplace_back(0);
    fin.triangles.emplace_back(0, 1, 4);
    expectError(ErrorOfMesh(fin), "3 triangles share the edge between vertices");
    ControlMesh turned = mesh;
    std::swap(turned.triangles[0].x, turned.triangles[0].y);
    expectError(ErrorOfMesh(turned), "wound in the same sense");
    ControlMesh large = mesh;
    for (Point3& p : large.p) p *= 1e38f;
    ShapeSetup scaled = SetupOf(large, 1);
    scaled.renderFromObject = Transform::Scale({1e20f, 1, 1});
    EXPECT_FALSE(ErrorOf(scaled).empty());
}

}  // namespace lacquer::test::loopsubdiv_test
