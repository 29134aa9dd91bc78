#include "pbrt/shapes/displacement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>

namespace lacquer::displacement_test {
namespace {

const FileLoc kLoc{"scene.pbrt", 7, 3};

/// A function of position and uv.
class Heights final : public FloatTexture {
  public:
    explicit Heights(std::function<float(Point3, Point2)> f) : f_(std::move(f)) {}
    float Evaluate(const TextureContext& context) const override { return f_(context.p, context.uv); }

  private:
    std::function<float(Point3, Point2)> f_;
};
const Heights kFlat([](Point3, Point2) { return 0.f; });

/// A square of side 2 in the plane z = 0 with normal +z, as one quad.
PlyMesh Square() {
    PlyMesh mesh;
    mesh.vertices.p = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    mesh.vertices.uv = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    mesh.quads = {{0, 1, 2, 3}};
    return mesh;
}

/// The faces around each edge.
std::map<std::pair<uint32_t, uint32_t>, int> Edges(const PlyMesh& mesh) {
    std::map<std::pair<uint32_t, uint32_t>, int> edges;
    for (const glm::uvec3 t : mesh.triangles)
        for (int k = 0; k < 3; ++k) ++edges[std::minmax(t[k], t[(k + 1) % 3])];
    return edges;
}

double Area(const PlyMesh& mesh) {
    double area = 0;
    const std::vector<Point3>& p = mesh.vertices.p;
    for (const glm::uvec3 t : mesh.triangles)
        area += 0.5 * double(glm::length(glm::cross(p[t.y] - p[t.x], p[t.z] - p[t.x])));
    return area;
}

TEST(Displacement, EdgesBecomeShorterThanAskedAndLeaveNoGaps) {
    for (const float length : {3.f, 2.f, 0.7f, 0.1f}) {
        PlyMesh mesh = Square();
        Displace(&mesh, kFlat, Transform(), length, kLoc);
        int onBorder = 0;
        for (const auto& [edge, count] : Edges(mesh)) {
            EXPECT_LT(glm::distance(mesh.vertices.p[edge.first], mesh.vertices.p[edge.second]), length);
            EXPECT_LE(count, 2);
            onBorder += count == 1;
            // An edge with one face inside of the square would be a gap.
            const Point3 middle = 0.5f * (mesh.vertices.p[edge.first] + mesh.vertices.p[edge.second]);
            const bool isAtBorder = std::max(std::abs(middle.x), std::abs(middle.y)) == 1;
            EXPECT_EQ(count == 1, isAtBorder);
        }
        EXPECT_GE(float(onBorder) * length, 8);
        EXPECT_NEAR(Area(mesh), 4, 1e-5);
    }
}

TEST(Displacement, LongEnoughEdgesStay) {
    PlyMesh mesh = Square();
    Displace(&mesh, kFlat, Transform(), 3, kLoc);
    EXPECT_EQ(mesh.triangles, (std::vector<glm::uvec3>{{0, 1, 2}, {0, 2, 3}}));
    EXPECT_TRUE(mesh.quads.empty());
    EXPECT_EQ(mesh.vertices.n, std::vector<Normal3>(4, Normal3(0, 0, 1)));
}

TEST(Displacement, VerticesMoveAlongNormalsByTheTextureOfTheObjectSpacePoint) {
    const auto height = [](Point3 p, Point2 uv) { return 0.1f * p.x * p.x + uv.y; };
    PlyMesh mesh = Square();
    // The transform counts for the length of edges only.
    Displace(&mesh, Heights(height), Transform::Scale({10, 10, 10}), 5, kLoc);
    EXPECT_GT(mesh.vertices.p.size(), 20u);
    for (size_t i = 0; i < mesh.vertices.p.size(); ++i) {
        const Point3 p = mesh.vertices.p[i];
        EXPECT_NEAR(p.z, height({p.x, p.y, 0}, mesh.vertices.uv[i]), 1e-6f);
        EXPECT_NEAR(mesh.vertices.uv[i].x, (p.x + 1) / 2, 1e-6f);
    }
    for (const auto& [edge, count] : Edges(mesh)) {
        const Vec2 d(mesh.vertices.p[edge.first] - mesh.vertices.p[edge.second]);
        EXPECT_LT(10 * glm::length(d), 5);
    }
}

TEST(Displacement, NormalsFollowTheSlope) {
    // A plane that rises by one half along x.
    PlyMesh mesh = Square();
    Displace(&mesh, Heights([](Point3 p, Point2) { return 0.5f * p.x; }), Transform(), 0.4f, kLoc);
    const Normal3 expected = glm::normalize(Vec3(-0.5f, 0, 1));
    for (const Normal3 n : mesh.vertices.n) EXPECT_LT(glm::distance(n, expected), 1e-5f);
}

TEST(Displacement, GivenNormalsSayWhereTo) {
    PlyMesh mesh = Square();
    mesh.vertices.n = std::vector<Normal3>(4, Normal3(0, 1, 0));
    Displace(&mesh, Heights([](Point3, Point2) { return 2.f; }), Transform(), 0.9f, kLoc);
    for (const Point3 p : mesh.vertices.p) EXPECT_EQ(p.z, 0);
    EXPECT_NEAR(mesh.vertices.p[0].y, 1, 1e-6f);
}

TEST(Displacement, PartsKeepTheNumberOfTheirFace) {
    PlyMesh mesh = Square();
    mesh.triangles = {{0, 1, 2}};
    mesh.triangleFaceIndices = {5};
    mesh.quadFaceIndices = {9};
    Displace(&mesh, kFlat, Transform(), 1, kLoc);
    ASSERT_EQ(mesh.triangleFaceIndices.size(), mesh.triangles.size());
    const auto fives = std::count(mesh.triangleFaceIndices.begin(), mesh.triangleFaceIndices.end(), 5);
    // The square has the triangle twice: once by itself, once in one of its two halves.
    EXPECT_EQ(3 * size_t(fives), mesh.triangles.size());
}

void ExpectError(PlyMesh mesh, const FloatTexture& texture, float length, const std::string& part) {
    try {
        Displace(&mesh, texture, Transform(), length, kLoc);
        ADD_FAILURE() << "no error: " << part;
    } catch (const SceneError& e) {
        EXPECT_NE(std::string(e.what()).find(part), std::string::npos) << e.what();
        EXPECT_EQ(e.Loc().line, 7);
    }
}

TEST(Displacement, MistakesAreErrors) {
    PlyMesh bare = Square();
    bare.vertices.uv.clear();
    ExpectError(bare, kFlat, 1, "needs vertices with uv");
    for (const float length : {0.f, -1.f, std::numeric_limits<float>::quiet_NaN()})
        ExpectError(Square(), kFlat, length, "positive edge length");
    ExpectError(Square(), Heights([](Point3, Point2) { return std::numeric_limits<float>::infinity(); }), 1,
                "not a finite number");
    ExpectError(Square(), kFlat, 1e-7f, "a larger \"edgelength\"");
}

TEST(Displacement, PointsThatCoincideEndTheRefinement) {
    // Neighbouring floats have none between them: the edge stays longer than asked.
    PlyMesh mesh = Square();
    for (Point3& p : mesh.vertices.p) p.x = p.x < 0 ? 1.f : std::nextafter(1.f, 2.f);
    for (Point3& p : mesh.vertices.p) p.y = p.y < 0 ? 1.f : std::nextafter(1.f, 2.f);
    Displace(&mesh, kFlat, Transform(), 1e-7f, kLoc);
    EXPECT_LE(mesh.triangles.size(), 8u);
}

}  // namespace
}  // namespace lacquer::displacement_test
