#include "pbrt/scattering/flake_field.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

namespace lacquer::flake_field_test {
namespace {

constexpr FlakeNormals kAllNormals;

FlakeWindow Disc(double x, double y, float radius) { return {x, y, {radius, 0}, {0, radius}}; }

/// All flakes of a window, by their bits.
std::map<uint64_t, Flake> FlakesIn(const FlakeField& field, const FlakeWindow& window,
                                   const FlakeNormals& normals = kAllNormals) {
    std::map<uint64_t, Flake> flakes;
    field.ForEach(window, normals, [&](const Flake& flake) { flakes[flake.bits] = flake; });
    return flakes;
}
bool HasTurn(const FlakeNormals& normals, float turn) { return normals.OverlapsTurns(turn, turn); }

/// A window of some shape and place, in which up to some thousand flakes are expected.
FlakeWindow RandomWindow(Rng& rng) {
    const float size = std::exp2(-6 + 7 * rng.Uniform()), ratio = 0.2f + 0.8f * rng.Uniform();
    const auto angle = double(rng.Uniform()) * 3;
    const Vec2 along(float(std::cos(angle)), float(std::sin(angle)));
    return {double(rng.Uniform()) * 2000 - 1000, double(rng.Uniform()) * 10, along * size,
            Vec2(-along.y, along.x) * (size * ratio)};
}

TEST(FlakeField, FindsByNormalsWhatTheWholeListHas) {
    const FlakeField field(11);
    Rng rng(1);
    int found = 0;
    for (int i = 0; i < 300; ++i) {
        const FlakeWindow window = RandomWindow(rng);
        FlakeNormals normals;
        normals.radialLow = rng.Uniform();
        normals.radialHigh = normals.radialLow + 0.3f * rng.Uniform();
        normals.turn = rng.Uniform();
        normals.halfTurn = i % 5 == 0 ? 1 : 0.3f * rng.Uniform();
        std::set<uint64_t> expected, actual;
        for (const auto& [bits, flake] : FlakesIn(field, window))
            if (flake.radial >= normals.radialLow && flake.radial <= normals.radialHigh &&
                HasTurn(normals, flake.turn))
                expected.insert(bits);
        for (const auto& [bits, flake] : FlakesIn(field, window, normals))
            if (flake.radial >= normals.radialLow && flake.radial <= normals.radialHigh &&
                HasTurn(normals, flake.turn))
                actual.insert(bits);
        EXPECT_EQ(actual, expected);
        found += int(expected.size());
    }
    EXPECT_GT(found, 1000);
}

TEST(FlakeField, CountsAndPicksEachFlakeOnce) {
    const FlakeField field(12);
    Rng rng(2);
    for (int i = 0; i < 100; ++i) {
        const FlakeWindow window = RandomWindow(rng);
        const std::map<uint64_t, Flake> flakes = FlakesIn(field, window);
        const int count = field.Count(window);
        ASSERT_EQ(count, int(flakes.size()));
        std::set<uint64_t> picked;
        for (int k = 0; k < count; ++k) {
            const Flake flake = field.Pick(window, k);
            EXPECT_TRUE(window.Contains(flake.offset));
            EXPECT_TRUE(flakes.contains(flake.bits));
            picked.insert(flake.bits);
        }
        EXPECT_EQ(int(picked.size()), count);
    }
}

// Zoom and animation: a flake is at the same place in windows of all sizes, and has the same normal.
TEST(FlakeField, AFlakeIsWhereItIsInAnyWindow) {
    const FlakeField field(13);
    Rng rng(3);
    int found = 0;
    for (int i = 0; i < 100; ++i) {
        const double x = double(rng.Uniform()) * 5, y = double(rng.Uniform()) * 5;
        const std::map<uint64_t, Flake> in = FlakesIn(field, Disc(x, y, 0.1f));
        const std::map<uint64_t, Flake> around = FlakesIn(field, Disc(x + 0.2, y - 0.3, 0.6f));
        for (const auto& [bits, flake] : in) {
            const auto other = around.find(bits);
            ASSERT_NE(other, around.end());
            EXPECT_NEAR(double(other->second.offset.x) + 0.2, double(flake.offset.x), 1e-6);
            EXPECT_NEAR(double(other->second.offset.y) - 0.3, double(flake.offset.y), 1e-6);
            EXPECT_EQ(other->second.radial, flake.radial);
            EXPECT_EQ(other->second.turn, flake.turn);
            ++found;
        }
    }
    EXPECT_GT(found, 300);
}

/// Pearson's statistic of the flakes of many tiles over 4^4 cells of position and normal; `twist` makes the
/// positions uneven. 255 degrees of freedom.
double ChiSquared(double twist) {
    const FlakeField field(14);
    std::array<int, 256> counts{};
    int total = 0;
    for (int tile = 0; tile < 400; ++tile)
        for (const auto& [bits, flake] : FlakesIn(field, Disc(tile + 0.5, 7.5, 0.75f))) {
            const double x = double(flake.offset.x) + 0.5, y = double(flake.offset.y) + 0.5;
            if (x < 0 || x >= 1 || y < 0 || y >= 1) continue;
            const auto cell = [](double u) { return std::min(size_t(u * 4), size_t(3)); };
            const double twisted = x + twist * x * (1 - x);
            ++counts[((cell(twisted) * 4 + cell(y)) * 4 + cell(double(flake.radial))) * 4 +
                     cell(double(flake.turn))];
            ++total;
        }
    double sum = 0;
    for (const int count : counts) sum += Sqr(count - total / 256.) / (total / 256.);
    return sum;
}

// 100,000 flakes, 400 in a cell: the test has the size 1e-4 (370 is the quantile of 255 degrees of freedom),
// and finds positions that are denser by 10 % on one side than on the other.
TEST(FlakeField, IsUniformInPositionAndNormal) {
    EXPECT_LT(ChiSquared(0), 370);
    EXPECT_GT(ChiSquared(0.1), 370) << "the negative control";
}

// Numbers of flakes in small windows have the mean and the variance of independent flakes: of 4,000 windows
// with 8 flakes, the mean is known to 0.6 % and the variance to 2.4 %.
TEST(FlakeField, NumbersInSmallWindowsAreThoseOfIndependentFlakes) {
    const FlakeField field(15);
    const double expected = 8, radius = std::sqrt(expected / (FlakeField::kMeanPerTile * 3.14159265358979));
    Rng rng(5);
    double sum = 0, squares = 0;
    constexpr int kWindows = 4000;
    for (int i = 0; i < kWindows; ++i) {
        const double x = double(rng.Uniform()) * 3000, y = double(rng.Uniform()) * 3000;
        const int count = field.Count(Disc(x, y, float(radius)));
        sum += count;
        squares += Sqr(double(count));
    }
    const double mean = sum / kWindows, variance = squares / kWindows - mean * mean;
    EXPECT_NEAR(mean / expected, 1, 0.025);
    EXPECT_NEAR(variance / expected, 1, 0.1);
}

TEST(FlakeField, AnotherSeedIsAnotherField) {
    const auto a = FlakesIn(FlakeField(1), Disc(0, 0, 0.5f)), b = FlakesIn(FlakeField(2), Disc(0, 0, 0.5f));
    for (const auto& [bits, flake] : a) EXPECT_FALSE(b.contains(bits));
}

TEST(FlakeField, FarTilesAndTinyWindowsAreFinite) {
    const FlakeField field(3);
    for (const double x : {0., -1e15, 1e15})
        for (const float radius : {1e-30f, 1e-6f, 2.f}) {
            const FlakeWindow window = Disc(x, -x, radius);
            const int count = field.Count(window);
            EXPECT_GE(count, 0);
            EXPECT_LT(count, 6000);
            if (count > 0) {
                EXPECT_TRUE(std::isfinite(field.Pick(window, count - 1).offset.x));
            }
        }
}

}  // namespace
}  // namespace lacquer::flake_field_test
