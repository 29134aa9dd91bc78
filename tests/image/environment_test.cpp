// Images of all directions in the equal-area mapping, against images that were made the other way: from a
// pixel to its direction.
#include "pbrt/image/environment.h"

#include <gtest/gtest.h>

#include <functional>

namespace lacquer::test::environment_test {
namespace {

/// The direction that a place of an image shows, by the geometry of each mapping; empty outside of the disks.
std::optional<Vec3> DirectionAt(EnvironmentMapping mapping, Point2 st) {
    if (mapping == EnvironmentMapping::EqualArea) return EqualAreaSquareToSphere(st);
    if (mapping == EnvironmentMapping::LatLong) {
        const float phi = 2 * Pi * st.x, theta = Pi * st.y;
        return Vec3(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
    }
    const float right = 2 * st.x - 1, up = 1 - 2 * st.y, r = std::hypot(right, up);
    if (r > 1) return std::nullopt;
    if (mapping == EnvironmentMapping::MirrorBall) {
        // The law of reflection at the ball's normal, for a camera on -x.
        const Vec3 toCamera(-1, 0, 0), n(-SafeSqrt(1 - r * r), right, up);
        return 2 * Dot(n, toCamera) * n - toCamera;
    }
    const float theta = Pi * r, s = r > 0 ? std::sin(theta) / r : 0;
    return Vec3(-std::cos(theta), -right * s, up * s);
}

Image MakeImage(EnvironmentMapping mapping, Int2 size, const std::function<RGB(Vec3)>& color) {
    Image image(size, {"R", "G", "B"});
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const auto w = DirectionAt(
                mapping, (Point2(float(x), float(y)) + 0.5f) / Point2(float(size.x), float(size.y)));
            // Outside of a disk, what must not be seen.
            const RGB rgb = w ? color(*w) : RGB(1e4f);
            for (int c = 0; c < 3; ++c) image.Set({x, y}, c, rgb[c]);
        }
    return image;
}

/// Different in all directions, and in each channel.
RGB Pattern(Vec3 w) {
    return {1 + w.x + 0.5f * w.y * w.z, 1.2f + w.y - 0.3f * w.x * w.z, 1.1f + w.z + 0.2f * w.x * w.y};
}

double LargestError(const Image& map, const std::function<RGB(Vec3)>& color,
                    const std::function<bool(Vec3)>& counts) {
    const int n = map.Resolution().x;
    double error = 0;
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) {
            const Vec3 w = EqualAreaSquareToSphere((Point2(float(x), float(y)) + 0.5f) / float(n));
            if (!counts(w)) continue;
            for (int c = 0; c < 3; ++c)
                error = std::max(error, double(std::abs(map.Get({x, y}, c) - color(w)[c])));
        }
    return error;
}

TEST(Environment, EachMappingShowsEachDirectionInItsPlace) {
    struct Case {
        EnvironmentMapping mapping;
        Int2 size;
        float rim;  // how near to +x: there, disks show the whole rim for few directions
    };
    for (const Case& c : {Case{EnvironmentMapping::LatLong, {512, 256}, 1},
                          Case{EnvironmentMapping::MirrorBall, {512, 512}, 0.95f},
                          Case{EnvironmentMapping::Angular, {512, 512}, 0.99f}}) {
        const Image map = ToEqualArea(MakeImage(c.mapping, c.size, Pattern), c.mapping, 128);
        const auto counts = [&](Vec3 w) { return w.x <= c.rim; };
        EXPECT_LT(LargestError(map, Pattern, counts), 0.02) << int(c.mapping);
        // What a mirrored image would be is seen.
        const auto mirrored = [](Vec3 w) { return Pattern({w.x, -w.y, w.z}); };
        EXPECT_GT(LargestError(map, mirrored, counts), 0.5) << int(c.mapping);
    }
}

TEST(Environment, PlacesInvertTheDirections) {
    for (int m = 0; m < 4; ++m) {
        const auto mapping = EnvironmentMapping(m);
        for (const Point2 st :
             {Point2(0.3f, 0.4f), Point2(0.72f, 0.31f), Point2(0.5f, 0.77f), Point2(0.51f, 0.49f)}) {
            const Vec3 w = *DirectionAt(mapping, st);
            EXPECT_NEAR(glm::distance(DirectionToImage(mapping, w), st), 0, 1e-4) << m;
        }
    }
}

TEST(Environment, SmallSunsKeepTheirEnergy) {
    // The disk of the sun, three pixels wide at the horizon, at several heights and across the seam.
    constexpr float kRadius = 0.5f * Pi / 180;
    for (const float theta : {0.5f, 3.f, 30.f, 90.f, 150.f}) {
        const float t = theta * Pi / 180;
        const Vec3 sun(std::sin(t), 0, std::cos(t));
        const auto isSun = [&](Vec3 w) { return Length(w - sun) < 2 * std::sin(kRadius / 2); };
        const Image image = MakeImage(EnvironmentMapping::LatLong, {1024, 512},
                                      [&](Vec3 w) { return RGB(isSun(w) ? 1e4f : 0.f); });
        double expected = 0;
        for (int y = 0; y < 512; ++y)
            for (int x = 0; x < 1024; ++x)
                expected += double(image.Get({x, y}, 1)) * std::sin(double(Pi) * (y + 0.5) / 512);
        expected *= 2 * double(Pi * Pi) / (1024 * 512);
        ASSERT_GT(expected, 0);
        const int side = EqualAreaSide({1024, 512}, EnvironmentMapping::LatLong);
        const Image map = ToEqualArea(image, EnvironmentMapping::LatLong, side);
        double sum = 0;
        for (const float v : map.Pixels()) sum += double(v) / 3;
        // Next to a pole, bilinear look-ups widen it towards rows of more area.
        EXPECT_NEAR(sum * 4 * double(Pi) / (double(side) * side) / expected, 1, theta < 5 ? 0.05 : 0.01)
            << theta;
    }
}

TEST(Environment, SunsKeepTheirEnergyInSmallMaps) {
    // Eight pixels of 1024 x 512, next to each other: a map of 16 x 16 pixels has one for 2048 of them.
    Image image({1024, 512}, {"Y"});
    for (int i = 0; i < 8; ++i) image.Set({700 + i % 3, 200 + i / 3}, 0, 1e4f);
    double expected = 0;
    for (int i = 0; i < 8; ++i) expected += 1e4 * std::sin(double(Pi) * (200.5 + i / 3) / 512);
    expected *= 2 * double(Pi * Pi) / (1024 * 512);
    for (const int side : {256, 16, 1}) {
        const Image map = ToEqualArea(image, EnvironmentMapping::LatLong, side);
        double sum = 0;
        for (const float v : map.Pixels()) sum += double(v);
        EXPECT_NEAR(sum * 4 * double(Pi) / (double(side) * side) / expected, 1, 0.02) << side;
    }
}

TEST(Environment, SidesAndNames) {
    EXPECT_EQ(EqualAreaSide({2048, 1024}, EnvironmentMapping::LatLong), 1449);
    EXPECT_EQ(EqualAreaSide({1000, 1000}, EnvironmentMapping::Angular), 887);
    EXPECT_EQ(EqualAreaSide({1, 1}, EnvironmentMapping::LatLong), 1);
    EXPECT_EQ(EqualAreaSide({30000, 15000}, EnvironmentMapping::LatLong), 8192);
    for (int m = 0; m < 4; ++m) EXPECT_EQ(int(EnvironmentMappingOf(EnvironmentMappingNames()[size_t(m)])), m);
    EXPECT_THROW(EnvironmentMappingOf("latlon"), std::out_of_range);
    EXPECT_EQ(WhyNotOfMapping({20, 10}, EnvironmentMapping::LatLong), "");
    EXPECT_NE(WhyNotOfMapping({20, 10}, EnvironmentMapping::Angular), "");
    EXPECT_NE(WhyNotOfMapping({20, 0}, EnvironmentMapping::LatLong), "");
}

}  // namespace
}  // namespace lacquer::test::environment_test
