#include "pbrt/shapes/bilinear_intersect.h"

#include <gtest/gtest.h>

#include "pbrt/core/rng.h"
#include "pbrt/core/sampling.h"
#include "support/statistics.h"

namespace lacquer::test::bilinear_intersect_test {

namespace {

struct Patch {
    glm::dvec3 p00, p10, p01, p11;
    glm::dvec3 At(double u, double v) const {
        return (1 - v) * ((1 - u) * p00 + u * p10) + v * ((1 - u) * p01 + u * p11);
    }
};

// Nearest hit with the triangles of an n x n tessellation.
std::optional<double> IntersectTessellation(const Ray& ray, const Patch& patch, int n) {
    std::optional<double> nearest;
    const glm::dvec3 o(ray.o), d(ray.d);
    const auto triangle = [&](glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) {
        const glm::dvec3 e1 = b - a, e2 = c - a, h = glm::cross(d, e2), s = o - a;
        const double det = glm::dot(e1, h), u = glm::dot(s, h) / det;
        const double v = glm::dot(d, glm::cross(s, e1)) / det, t = glm::dot(e2, glm::cross(s, e1)) / det;
        if (u >= 0 && v >= 0 && u + v <= 1 && t > 0 && (!nearest || t < *nearest)) nearest = t;
    };
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const auto p = [&](int x, int y) { return patch.At(double(x) / n, double(y) / n); };
            triangle(p(i, j), p(i + 1, j), p(i + 1, j + 1));
            triangle(p(i, j), p(i + 1, j + 1), p(i, j + 1));
        }
    return nearest;
}

std::optional<BilinearHit> Intersect(const Ray& ray, const Patch& q) {
    return IntersectBilinear(ray, 0, double(Infinity), Point3(q.p00), Point3(q.p10), Point3(q.p01),
                             Point3(q.p11));
}

}  // namespace

// The tessellation leaves the patch by at most |twist| / (4 n^2), at grazing angles more along the ray: rays
// whose two answers differ must be few, near silhouettes and edges.
TEST(BilinearIntersect, AgreesWithDenseTriangles) {
    const std::vector<Patch> patches = {
        {{-1, -0.8, -0.5}, {1, -0.8, 0.5}, {-1, 0.9, 0.6}, {1, 0.9, -0.6}},
        {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}},
        {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1.5, 1.5, 0}},
        {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 1, 0}},        // a triangle
        {{0, 0, 0}, {1, 0.2, 0}, {1, 0.2, 1}, {0, 0, 1.3}},  // folded over
    };
    Rng rng(SeedOf(FullTestName()));
    for (const Patch& patch : patches) {
        int hits = 0, disagreements = 0;
        for (int i = 0; i < 600; ++i) {
            const Point3 target(
                patch.At(double(rng.Uniform()) * 1.2 - 0.1, double(rng.Uniform()) * 1.2 - 0.1));
            const Point3 o = target + 2.f * SampleUniformSphere(rng.Uniform2D());
            const Ray ray{o, (target - o) * 0.7f};
            const auto hit = Intersect(ray, patch);
            const auto reference = IntersectTessellation(ray, patch, 40);
            if (hit) {
                ++hits;
                const glm::dvec3 p = glm::dvec3(ray.o) + hit->t * glm::dvec3(ray.d);
                EXPECT_LT(glm::length(p - patch.At(hit->u, hit->v)), 1e-6);
            }
            if (hit.has_value() != reference.has_value() || (hit && std::abs(hit->t - *reference) > 5e-3))
                ++disagreements;
        }
        EXPECT_GT(hits, 200);
        EXPECT_LE(disagreements, 15);
    }
}

TEST(BilinearIntersect, FindsBothSheetsOneAfterTheOther) {
    const Patch saddle{{-1, -1, 1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, 1}};  // z = x y
    // Along x = y + 0 at height 0.25: meets x^2 = 0.25 twice.
    const Ray ray{{-2, -2, 0.25f}, {1, 1, 0}};
    const auto first = Intersect(ray, saddle);
    ASSERT_TRUE(first);
    EXPECT_NEAR(first->t, 1.5, 1e-12);
    const auto second = IntersectBilinear(ray, first->t + 1e-6, 10, Point3(saddle.p00), Point3(saddle.p10),
                                          Point3(saddle.p01), Point3(saddle.p11));
    ASSERT_TRUE(second);
    EXPECT_NEAR(second->t, 2.5, 1e-12);
}

TEST(BilinearIntersect, NeighboursLeaveNoGap) {
    // Rays through the shared edge of two patches with corners that do not fit the float grid.
    const Point3 a(0.1f, 0.2f, 0.3f), b(0.7f, 1.1f, 0.2f), c(-1.3f, 0.4f, 0.9f), d(-0.9f, 1.7f, -0.2f),
        e(1.9f, 0.3f, 0.1f), f(2.1f, 1.3f, 0.6f);
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 5000; ++i) {
        const float t = rng.Uniform();
        const Point3 target = a + t * (b - a);
        const Point3 o = target + Vec3(rng.Uniform() - 0.5f, rng.Uniform() - 0.5f, 2);
        const Ray ray{o, target - o};
        EXPECT_TRUE(IntersectBilinear(ray, 0, 10, c, a, d, b) || IntersectBilinear(ray, 0, 10, a, e, b, f));
    }
}

TEST(BilinearIntersect, DegeneratePatchesAreMissed) {
    const Point3 p(1, 2, 3);
    EXPECT_FALSE(IntersectBilinear({{0, 0, 0}, {1, 2, 3}}, 0, 10, p, p, p, p));
    EXPECT_FALSE(
        IntersectBilinear({{0, 0, 1}, {0, 0, -1}}, 0, 10, {-1, 0, 0}, {1, 0, 0}, {-1, 0, 0}, {1, 0, 0}));
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_FALSE(
        IntersectBilinear({{nan, 0, 1}, {0, 0, -1}}, 0, 10, {-1, -1, 0}, {1, -1, 0}, {-1, 1, 0}, {1, 1, 0}));
}

}  // namespace lacquer::test::bilinear_intersect_test
