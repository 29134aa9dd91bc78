// The walk through a grid of bounds, against points on the ray.
#include <gtest/gtest.h>

#include <vector>

#include "pbrt/base/medium.h"
#include "pbrt/core/rng.h"
#include "support/lanes.h"
#include "support/statistics.h"

namespace lacquer::test::majorant_walk_test {
namespace {

/// A grid whose cells all have a bound of their own, or none where `emptyEvery`-th in order.
MajorantGrid Numbered(const Bounds3& box, Int3 resolution, int emptyEvery = 0) {
    MajorantGrid grid(box, resolution);
    int number = 0;
    for (int z = 0; z < resolution.z; ++z)
        for (int y = 0; y < resolution.y; ++y)
            for (int x = 0; x < resolution.x; ++x, ++number)
                grid.Set({x, y, z}, emptyEvery && number % emptyEvery == 0 ? 0.f : float(number + 1));
    return grid;
}

std::vector<MajorantSegment> SegmentsOf(const MajorantGrid& grid, const Ray& ray, float tMax) {
    MajorantWalk walk(grid, ray, tMax, SampledSpectrum(1));
    std::vector<MajorantSegment> segments;
    MajorantSegment segment;
    while (walk.Next(&segment)) segments.push_back(segment);
    return segments;
}

/// Range of the bounds that the point may have: those of all cells within `slack` (in box lengths) of it; {0,
/// 0} far outside. In double, so that only the walk's own rounding needs slack.
struct Range {
    double low = 1e30, high = -1;
};
Range BoundsAt(const MajorantGrid& grid, const Ray& ray, double t, double slack) {
    const Bounds3& box = grid.Bounds();
    const Int3 n = grid.Resolution();
    int first[3], last[3];
    bool mayBeOutside = false;
    for (int axis = 0; axis < 3; ++axis) {
        const double u = (double(ray.o[axis]) + t * double(ray.d[axis]) - double(box.min[axis])) /
                         (double(box.max[axis]) - double(box.min[axis]));
        if (u < slack || u > 1 - slack) mayBeOutside = true;
        if (u < -slack || u > 1 + slack) return {0, 0};
        first[axis] = std::clamp(int(std::floor((u - slack) * n[axis])), 0, n[axis] - 1);
        last[axis] = std::clamp(int(std::floor((u + slack) * n[axis])), 0, n[axis] - 1);
    }
    Range range;
    if (mayBeOutside) range = {0, 0};
    for (int z = first[2]; z <= last[2]; ++z)
        for (int y = first[1]; y <= last[1]; ++y)
            for (int x = first[0]; x <= last[0]; ++x) {
                range.low = std::min(range.low, double(grid.At({x, y, z})));
                range.high = std::max(range.high, double(grid.At({x, y, z})));
            }
    return range;
}

/// Checks order, limits, and the bound at `numPoints` points of [0, tMax] against that of the `reference`.
testing::AssertionResult Agrees(const MajorantGrid& grid, const MajorantGrid& reference, const Ray& ray,
                                float tMax, double slack, int numPoints, Rng& rng) {
    const std::vector<MajorantSegment> segments = SegmentsOf(grid, ray, tMax);
    float end = 0;
    for (const MajorantSegment& s : segments) {
        if (!(s.tMin >= end && s.tMax > s.tMin && s.tMax <= tMax))
            return testing::AssertionFailure()
                   << "segment " << s.tMin << " ... " << s.tMax << " after " << end;
        if (!(s.sigmaMaj[0] > 0)) return testing::AssertionFailure() << "an empty segment";
        end = s.tMax;
    }
    for (int i = 0; i < numPoints; ++i) {
        const double t = double(rng.Uniform()) * double(tMax);
        double found = 0;
        for (const MajorantSegment& s : segments)
            if (t >= double(s.tMin) && t < double(s.tMax)) found = double(s.sigmaMaj[0]);
        const Range range = BoundsAt(reference, ray, t, slack);
        if (found < range.low || found > range.high)
            return testing::AssertionFailure() << "bound " << found << " instead of " << range.low << " ... "
                                               << range.high << " at t = " << t;
    }
    return testing::AssertionSuccess();
}

testing::AssertionResult Agrees(const MajorantGrid& grid, const Ray& ray, float tMax, double slack,
                                int numPoints, Rng& rng) {
    return Agrees(grid, grid, ray, tMax, slack, numPoints, rng);
}

Point3 RandomPoint(Rng& rng) { return {rng.Uniform(), rng.Uniform(), rng.Uniform()}; }

const Bounds3 kBox({-1, 2, 0.5f}, {3, 2.5f, 7});
constexpr Int3 kResolution{7, 3, 16};

// Rays start within some box lengths of the box: their points are wrong by some 2^-24 of that. 1e-5 is a
// hundred times as much, and a thousandth of a cell.
constexpr double kSlack = 1e-5;

TEST(MajorantWalk, HasTheBoundOfEachPointsCell) {
    Rng rng(SeedOf(FullTestName()));
    for (const int emptyEvery : {0, 2, 5}) {
        const MajorantGrid grid = Numbered(kBox, kResolution, emptyEvery);
        for (int i = 0; i < 500; ++i) {
            // From around the box, and so from inside as well, through a point of it.
            const Point3 from = kBox.min + (3.f * RandomPoint(rng) - 1.f) * kBox.Diagonal();
            const Point3 through = kBox.min + RandomPoint(rng) * kBox.Diagonal();
            const Ray ray{from, through - from};
            ASSERT_TRUE(Agrees(grid, ray, 3, kSlack, 50, rng)) << "ray " << i;
        }
    }
}

TEST(MajorantWalk, MissesWhatItMisses) {
    Rng rng(SeedOf(FullTestName()));
    const MajorantGrid grid = Numbered(kBox, kResolution);
    for (int i = 0; i < 500; ++i) {
        const Point3 from = kBox.min + (3.f * RandomPoint(rng) - 1.f) * kBox.Diagonal();
        ASSERT_TRUE(Agrees(grid, Ray{from, RandomPoint(rng) - RandomPoint(rng)}, 10, kSlack, 20, rng));
    }
}

TEST(MajorantWalk, GoesAlongAnAxis) {
    Rng rng(SeedOf(FullTestName()));
    const MajorantGrid grid = Numbered(kBox, kResolution);
    for (int axis = 0; axis < 3; ++axis)
        for (const float sign : {-1.f, 1.f})
            for (const float zero : {0.f, -0.f})
                for (int i = 0; i < 20; ++i) {
                    Vec3 d(zero);
                    d[axis] = sign * kBox.Diagonal()[axis];
                    Point3 o = kBox.min + RandomPoint(rng) * kBox.Diagonal();
                    o[axis] -= 2 * rng.Uniform() * d[axis];
                    ASSERT_TRUE(Agrees(grid, Ray{o, d}, 4, kSlack, 50, rng));
                    o[(axis + 1) % 3] = kBox.max[(axis + 1) % 3] + 0.01f;
                    EXPECT_TRUE(SegmentsOf(grid, Ray{o, d}, 4).empty()) << "outside";
                }
}

TEST(MajorantWalk, GoesAlongWallsEdgesAndDiagonals) {
    // A box whose walls are floats: rays lie in them exactly, and cross edges of cells.
    Rng rng(SeedOf(FullTestName()));
    const MajorantGrid grid = Numbered({Point3(0), Point3(4)}, Int3(4));
    for (int wall = 0; wall <= 4; ++wall)
        for (int axis = 0; axis < 3; ++axis) {
            Point3 o{float(wall)};
            Vec3 d(0);
            o[axis] = -1;
            d[axis] = 1;
            ASSERT_TRUE(Agrees(grid, Ray{o, d}, 6, kSlack, 50, rng)) << "edge " << wall;
            EXPECT_FALSE(SegmentsOf(grid, Ray{o, d}, 6).empty());
            o[(axis + 1) % 3] = 2.5f;
            ASSERT_TRUE(Agrees(grid, Ray{o, d}, 6, kSlack, 50, rng)) << "wall " << wall;
            d[(axis + 1) % 3] = -1;
            ASSERT_TRUE(Agrees(grid, Ray{o, d}, 6, kSlack, 50, rng)) << "across wall " << wall;
        }
    for (int i = 0; i < 8; ++i) {
        const Vec3 d(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
        const Ray ray{Point3(2) - 3.f * d, d};
        ASSERT_TRUE(Agrees(grid, ray, 6, kSlack, 100, rng));
        EXPECT_EQ(SegmentsOf(grid, ray, 6).size(), 4u) << "corners of cells take no length";
    }
}

TEST(MajorantWalk, LengthsAddUp) {
    Rng rng(SeedOf(FullTestName()));
    const MajorantGrid grid = Numbered({Point3(0), Point3(1)}, {128, 128, 128});
    for (int i = 0; i < 200; ++i) {
        const Point3 from = RandomPoint(rng);
        const Ray ray{from, Normalize(RandomPoint(rng) - from)};
        double length = 0, exit = 1e30;
        for (const MajorantSegment& s : SegmentsOf(grid, ray, 10)) length += double(s.tMax) - double(s.tMin);
        for (int axis = 0; axis < 3; ++axis)
            exit = std::min(exit, (double(ray.d[axis] > 0) - double(from[axis])) / double(ray.d[axis]));
        ASSERT_NEAR(length, exit, 1e-6 * exit) << "some roundings of the exit, whatever the number of cells";
    }
}

TEST(MajorantWalk, IsAsGoodFarAway) {
    // Points of the ray are wrong by about |o| 2^-24 = 6e-4 here.
    Rng rng(SeedOf(FullTestName()));
    const MajorantGrid grid = Numbered({Point3(0), Point3(1)}, {32, 32, 32});
    for (int i = 0; i < 100; ++i) {
        const Vec3 d = Normalize(RandomPoint(rng) - 0.5f);
        const Ray ray{RandomPoint(rng) - 1e4f * d, d};
        ASSERT_TRUE(Agrees(grid, ray, 2e4f, 4e-3, 2000, rng));
    }
}

TEST(MajorantWalk, EndsAtTMaxAndLooksOnlyForward) {
    const MajorantGrid grid = Numbered({Point3(0), Point3(1)}, {4, 1, 1});
    const Ray ray{{-1, 0.5f, 0.5f}, {1, 0, 0}};
    EXPECT_TRUE(SegmentsOf(grid, ray, 1).empty());
    const auto segments = SegmentsOf(grid, ray, 1.3f);
    ASSERT_EQ(segments.size(), 2u);
    EXPECT_EQ(segments[0].tMin, 1);
    EXPECT_EQ(segments[1].tMax, 1.3f);
    EXPECT_EQ(SegmentsOf(grid, ray, Infinity).size(), 4u);
    EXPECT_EQ(SegmentsOf(grid, ray, Infinity).back().tMax, 2);
    EXPECT_TRUE(SegmentsOf(grid, Ray{{2, 0.5f, 0.5f}, {1, 0, 0}}, 10).empty()) << "the box lies behind";
    EXPECT_TRUE(SegmentsOf(grid, ray, 0).empty());
    EXPECT_TRUE(SegmentsOf(grid, ray, -1).empty());
}

TEST(MajorantWalk, SkipsEmptyCells) {
    MajorantGrid grid({Point3(0), Point3(1)}, {8, 1, 1});
    const Ray ray{{-1, 0.5f, 0.5f}, {1, 0, 0}};
    EXPECT_TRUE(SegmentsOf(grid, ray, 10).empty());
    grid.Set({5, 0, 0}, 3);
    MajorantWalk walk(grid, ray, 10, Lanes(1, 2, 3, 4));
    MajorantSegment segment;
    ASSERT_TRUE(walk.Next(&segment));
    EXPECT_EQ(segment.tMin, 1.625f);
    EXPECT_EQ(segment.tMax, 1.75f);
    EXPECT_EQ(segment.sigmaMaj, Lanes(3, 6, 9, 12));
    EXPECT_FALSE(walk.Next(&segment));
    EXPECT_FALSE(walk.Next(&segment));
}

TEST(MajorantWalk, TakesExtremeRays) {
    Rng rng(SeedOf(FullTestName()));
    const MajorantGrid grid = Numbered({Point3(0), Point3(1)}, {16, 16, 16});
    for (const float tiny : {1e-20f, 1e-38f, 1e-45f})
        for (const float o : {0.f, 0.3f, 0.5f, 1.f})
            ASSERT_TRUE(Agrees(grid, Ray{{-1, o, 0.3f}, {1, tiny, -tiny}}, 5, kSlack, 50, rng))
                << tiny << " " << o;
    ASSERT_TRUE(Agrees(grid, Ray{Point3(0.3f), {1e-10f, 1e-10f, 2e-10f}}, 1e10f, kSlack, 50, rng));
    ASSERT_TRUE(Agrees(grid, Ray{Point3(-3e9f), Vec3(1e10f)}, 1, 1e-1, 50, rng));
    EXPECT_LE(SegmentsOf(grid, Ray{Point3(0.3f), Vec3(0)}, 1).size(), 1u) << "a direction without length";
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_LE(SegmentsOf(grid, Ray{Point3(nan), Vec3(1)}, 1).size(), 48u);
    EXPECT_LE(SegmentsOf(grid, Ray{Point3(0), Vec3(nan)}, 1).size(), 48u);
}

TEST(MajorantWalk, FindsNothingInBoxesWithoutVolume) {
    for (const Bounds3& box : {Bounds3({0, 0, 0}, {1, 0, 1}), Bounds3({0, 0, 0}, {0, 0, 0}), Bounds3()}) {
        const MajorantGrid grid = Numbered(box, {4, 4, 4});
        EXPECT_TRUE(SegmentsOf(grid, Ray{{-1, 0, 0.5f}, {1, 0, 0}}, 10).empty());
        EXPECT_TRUE(SegmentsOf(grid, Ray{{0.5f, -1, 0.5f}, {0, 1, 0}}, 10).empty());
        EXPECT_TRUE(SegmentsOf(grid, Ray{Point3(-1), Vec3(1)}, 10).empty());
    }
}

TEST(MajorantWalk, OfOneSegment) {
    MajorantWalk walk(0.5f, 2, SampledSpectrum(3));
    MajorantSegment segment;
    ASSERT_TRUE(walk.Next(&segment));
    EXPECT_EQ(segment.tMin, 0.5f);
    EXPECT_EQ(segment.tMax, 2);
    EXPECT_EQ(segment.sigmaMaj[3], 3);
    EXPECT_FALSE(walk.Next(&segment));
    EXPECT_FALSE(MajorantWalk().Next(&segment));
}

TEST(MajorantWalk, ChecksAboveSeeAWrongCell) {
    // Negative control: against a grid that lies a tenth of a cell further.
    Rng rng(SeedOf(FullTestName()));
    const MajorantGrid grid = Numbered(kBox, kResolution);
    const Vec3 shift(0.1f * kBox.Diagonal().x / float(kResolution.x), 0, 0);
    const MajorantGrid moved = Numbered({kBox.min + shift, kBox.max + shift}, kResolution);
    const Point3 from(-2, 2.2f, 1);
    const Ray ray{from, Point3(4, 2.3f, 5) - from};
    EXPECT_TRUE(Agrees(grid, ray, 1, kSlack, 500, rng));
    EXPECT_FALSE(Agrees(grid, moved, ray, 1, kSlack, 500, rng));
}

}  // namespace
}  // namespace lacquer::test::majorant_walk_test
