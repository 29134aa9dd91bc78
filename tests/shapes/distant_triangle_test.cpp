// Light samples of triangles by about the cosine at the surface: densities, and how far what they find is
// from them.
#include "pbrt/shapes/distant_triangle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "pbrt/core/rng.h"
#include "pbrt/core/sampling.h"

namespace lacquer::distant_triangle_test {
namespace {

using glm::dvec3;

/// Random triangles of some shape, seen by surfaces of any orientation from `size` times nearer than they are
/// large.
struct Seen {
    LightReference ref;
    std::array<Point3, 3> corners;

    Seen(float size, float unit, Rng* rng) {
        const auto around = [&] { return Vec3(rng->Uniform(), rng->Uniform(), rng->Uniform()) - 0.5f; };
        for (Point3& p : corners) p = around();
        const Vec3 away = Normalize(around());
        const float longest = std::max({Length(corners[1] - corners[0]), Length(corners[2] - corners[1]),
                                        Length(corners[0] - corners[2])});
        const Point3 center = (corners[0] + corners[1] + corners[2]) / 3.f;
        const auto nearest = [&](float distance) {
            const Point3 from = center + distance * away;
            return std::min(
                {Length(corners[0] - from), Length(corners[1] - from), Length(corners[2] - from)});
        };
        float low = 0, high = longest * (1 + 1 / size);
        for (int i = 0; i < 50; ++i) {
            const float middle = (low + high) / 2;
            (nearest(middle) < longest / size ? low : high) = middle;
        }
        ref.p = unit * (center + high * away);
        for (Point3& p : corners) p *= unit;
        ref.n = ref.ns = Normalize(around());
    }
    Point3 At(Vec3 b) const { return b.x * corners[0] + b.y * corners[1] + b.z * corners[2]; }
    /// cos(theta) cos(theta') / r^2 at a point, up to the lengths' unit.
    double Arriving(Vec3 b, bool withCosine = true) const {
        const dvec3 d = dvec3(At(b)) - dvec3(ref.p),
                    normal = glm::cross(dvec3(corners[1]) - dvec3(corners[0]),
                                        dvec3(corners[2]) - dvec3(corners[0]));
        const double r = glm::length(d), cosine = std::max(0., glm::dot(d, dvec3(ref.ns)) / r);
        return (withCosine ? cosine : 1.) * std::abs(glm::dot(d, normal)) / (r * r * r);
    }
};

/// The mean, variance and maximum of what is found over the density, of points uniform by area.
struct Quality {
    double variance = 0, maximum = 0;  ///< over the squared mean, and over the mean

    template <class Density>
    Quality(const Seen& seen, const Density& density) {
        constexpr int kSide = 60;
        double sum = 0, sumSquares = 0, n = 0;
        for (int i = 0; i < kSide; ++i)
            for (int j = 0; j < kSide; ++j) {
                const Vec3 b = SampleUniformTriangle({(float(i) + 0.5f) / kSide, (float(j) + 0.5f) / kSide});
                const double f = seen.Arriving(b), q = f / density(b);
                sum += f;
                sumSquares += f * q;
                maximum = std::max(maximum, q);
                ++n;
            }
        variance = n * sumSquares / (sum * sum) - 1;
        maximum *= n / sum;
    }
};

double Median(std::vector<double> values) {
    std::nth_element(values.begin(), values.begin() + long(values.size() / 2), values.end());
    return values[values.size() / 2];
}

TEST(DistantTriangle, IsThereUpToASize) {
    Rng rng(2);
    for (int i = 0; i < 200; ++i) {
        const Seen inside(1.2f, 1, &rng), outside(1.3f, 1, &rng);
        EXPECT_TRUE(DistantTriangle::From(inside.ref, inside.corners));
        EXPECT_FALSE(DistantTriangle::From(outside.ref, outside.corners));
    }
    const Seen seen(1, 1, &rng);
    LightReference corner = seen.ref;
    corner.p = seen.corners[1];
    EXPECT_FALSE(DistantTriangle::From(corner, seen.corners));
    corner.p = Point3(std::nanf(""));
    EXPECT_FALSE(DistantTriangle::From(corner, seen.corners));
}

// The density that a sample brings is that of its point, and one over it has the mean 1: at any unit of
// lengths.
TEST(DistantTriangle, SamplesHaveTheirDensity) {
    Rng rng(3);
    for (const float unit : {1e-15f, 1e-3f, 1.f, 1e5f, 1e15f})
        for (const float size : {1e-3f, 0.3f, 1.2f}) {
            const Seen seen(size, unit, &rng);
            const auto triangle = DistantTriangle::From(seen.ref, seen.corners);
            ASSERT_TRUE(triangle);
            double sum = 0;
            constexpr int kSide = 100;
            for (int i = 0; i < kSide; ++i)
                for (int j = 0; j < kSide; ++j) {
                    const Point2 u((float(i) + 0.5f) / kSide, (float(j) + 0.5f) / kSide);
                    const DistantTriangle::Drawn drawn = triangle->Sample(u);
                    EXPECT_NEAR(drawn.b.x + drawn.b.y + drawn.b.z, 1, 1e-6f);
                    EXPECT_GE(std::min({drawn.b.x, drawn.b.y, drawn.b.z}), 0);
                    EXPECT_NEAR(triangle->Density(drawn.b) / drawn.density, 1, 1e-5f);
                    sum += double(1 / drawn.density) / (kSide * kSide);
                }
            EXPECT_NEAR(sum, 1, 1e-3) << unit << " " << size;
        }
}

// Moments of samples against quadrature with the density; the control takes the density of another surface.
TEST(DistantTriangle, SamplesAreDistributedByTheDensity) {
    Rng rng(5);
    for (int k = 0; k < 20; ++k) {
        const Seen seen(1.2f, 1, &rng);
        Seen other = seen;
        other.ref.ns = -Normalize(Cross(seen.ref.ns, seen.corners[0] - seen.ref.p));
        const auto triangle = DistantTriangle::From(seen.ref, seen.corners),
                   wrong = DistantTriangle::From(other.ref, other.corners);
        Vec3 drawn(0), byDensity(0), byWrong(0);
        constexpr int kSide = 200;
        for (int i = 0; i < kSide; ++i)
            for (int j = 0; j < kSide; ++j) {
                const Point2 u((float(i) + 0.5f) / kSide, (float(j) + 0.5f) / kSide);
                drawn += triangle->Sample(u).b / float(kSide * kSide);
                const Vec3 b = SampleUniformTriangle(u);
                byDensity += b * (triangle->Density(b) / (kSide * kSide));
                byWrong += b * (wrong->Density(b) / (kSide * kSide));
            }
        EXPECT_LT(Length(drawn - byDensity), 2e-4f);
        EXPECT_GT(Length(drawn - byWrong), 2e-3f);
    }
}

// What it is for: less variance of diffuse light than by solid angle up to its size, and far less than by
// area; and no samples that count for much more than others where most of the triangle is above the horizon.
TEST(DistantTriangle, FollowsDiffuseLight) {
    Rng rng(7);
    for (const float size : {0.25f, 0.5f, 1.f, 1.24f}) {
        std::vector<double> mine, bySolidAngle, byArea, most;
        for (int k = 0; k < 300; ++k) {
            const Seen seen(size, 1, &rng);
            // Whole above the horizon: what reaches below is wasted by any of them.
            bool isAbove = true;
            for (const Point3 p : seen.corners) isAbove &= Dot(Normalize(p - seen.ref.p), seen.ref.ns) > 0.1f;
            if (!isAbove) continue;
            const auto triangle = DistantTriangle::From(seen.ref, seen.corners);
            ASSERT_TRUE(triangle);
            double solidAngle = 0;
            constexpr int kSide = 60;
            for (int i = 0; i < kSide * kSide; ++i)
                solidAngle += seen.Arriving(SampleUniformTriangle({(float(i % kSide) + 0.5f) / kSide,
                                                                   (float(i / kSide) + 0.5f) / kSide}),
                                            false) /
                              (kSide * kSide);
            const Quality quality(seen, [&](Vec3 b) { return double(triangle->Density(b)); });
            mine.push_back(quality.variance);
            most.push_back(quality.maximum);
            bySolidAngle.push_back(
                Quality(seen, [&](Vec3 b) { return seen.Arriving(b, false) / solidAngle; }).variance);
            byArea.push_back(Quality(seen, [](Vec3) { return 1.; }).variance);
        }
        ASSERT_GT(mine.size(), 50u);
        EXPECT_LT(Median(mine), (size <= 0.5f ? 0.3 : 1.2) * Median(bySolidAngle)) << size;
        EXPECT_LT(Median(mine), 0.4 * Median(byArea)) << size;
        EXPECT_LT(*std::max_element(most.begin(), most.end()), 1 + double(size)) << size;
    }
}

}  // namespace
}  // namespace lacquer::distant_triangle_test
