#include "pbrt/materials/flake_layout.h"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

namespace lacquer::flake_layout_test {
namespace {

/// A footprint of a width and a height, turned by 30 degrees.
TextureContext Footprint(float width, float height) {
    TextureContext context;
    context.uv = {0.3f, 0.7f};
    context.dudx = 0.8660254f * width;
    context.dvdx = 0.5f * width;
    context.dudy = -0.5f * height;
    context.dvdy = 0.8660254f * height;
    return context;
}
FlakeLayout Layout() { return {.seed = 5, .density = 1e5f, .radius = 1e-3f, .scale = {1, 1}}; }
/// Half axes of a window in the plane.
Vec2 ExtentOf(const FlakesInWindow& flakes, const FlakeLayout& layout) {
    return flakes.window.Extent() / float(layout.TilesPerUnit());
}

TEST(FlakeLayout, WindowsAreFootprintsWithARimOfAFlake) {
    const FlakeLayout layout = Layout();
    const FlakesInWindow flakes = layout.WindowAt(Footprint(0.02f, 0.01f), 1e9f);
    // Half axes 0.011 and 0.006 of a turned ellipse.
    const double c = 0.8660254, s = 0.5;
    EXPECT_NEAR(double(ExtentOf(flakes, layout).x), std::hypot(0.011 * c, 0.006 * s), 1e-6);
    EXPECT_NEAR(double(ExtentOf(flakes, layout).y), std::hypot(0.011 * s, 0.006 * c), 1e-6);
    EXPECT_NEAR(double(flakes.areaShare), 1e-6 / (0.011 * 0.006), 1e-5);
    EXPECT_NEAR(flakes.window.X(), 0.3 * layout.TilesPerUnit(), 1e-6 * layout.TilesPerUnit());
    // A point has the flakes that cover it.
    const FlakesInWindow point = layout.WindowAt(Footprint(0, 0), 1e9f);
    EXPECT_NEAR(double(ExtentOf(point, layout).x), 1e-3, 1e-9);
    EXPECT_NEAR(double(point.areaShare), 1, 1e-5);
}

TEST(FlakeLayout, LargeFootprintsAreCutToTheMostFlakesAskedFor) {
    const FlakeLayout layout = Layout();
    for (const float width : {0.1f, 10.f, 1e12f}) {
        const FlakesInWindow flakes = layout.WindowAt(Footprint(width, width), 300);
        EXPECT_NEAR(double(layout.density * layout.AreaOfFlake() / flakes.areaShare), 300, 1) << width;
        const int count = flakes.field.Count(flakes.window);
        EXPECT_GT(count, 200);
        EXPECT_LT(count, 400);
    }
    // Never below the size of a flake, however many overlap.
    EXPECT_NEAR(double(layout.WindowAt(Footprint(1, 1), 0.1f).areaShare), 1, 1e-5);
}

TEST(FlakeLayout, LongFootprintsAreFourTimesAsLongAsWide) {
    const FlakeLayout layout = Layout();
    const FlakesInWindow flakes = layout.WindowAt(Footprint(1, 0.002f), 1e9f);
    EXPECT_NEAR(double(flakes.areaShare), 1e-6 / (0.008 * 0.002), 1e-4);
}

TEST(FlakeLayout, CoverageIsThatOfOverlappingFlakes) {
    EXPECT_NEAR(double(Layout().Coverage()), 1 - std::exp(-1e5 * std::numbers::pi * 1e-6), 1e-6);
}

TEST(FlakeLayout, FootprintsThatAreNoNumbersArePoints) {
    const FlakeLayout layout = Layout();
    for (const float bad :
         {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        TextureContext context = Footprint(bad, bad);
        context.uv = {bad, 0};
        const FlakesInWindow flakes = layout.WindowAt(context, 100);
        EXPECT_TRUE(std::isfinite(flakes.window.X()));
        EXPECT_NEAR(double(flakes.areaShare), 1, 1e-5);
    }
}

}  // namespace
}  // namespace lacquer::flake_layout_test
