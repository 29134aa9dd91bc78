// Materials by formula.
#include "materialgan/procedural/procedural.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lacquer::materialgan::procedural_test {
namespace {

constexpr int kSize = 32;

TEST(FractalNoise, HasMeanZeroAndDeviationOne) {
    Rng rng(Hash(1));
    const Field field = FractalNoise(64, 1.5, 1, rng);
    double sum = 0, squares = 0;
    for (const double v : field) {
        sum += v;
        squares += v * v;
    }
    EXPECT_NEAR(sum / double(field.size()), 0, 1e-9);
    EXPECT_NEAR(squares / double(field.size()), 1, 1e-9);
}

/// Correlation of neighbours, across the border too.
double NeighbourCorrelation(const Field& field, size_t size, bool alongX) {
    double sum = 0;
    for (size_t row = 0; row < size; ++row)
        for (size_t column = 0; column < size; ++column) {
            const size_t next = alongX ? row * size + (column + 1) % size : (row + 1) % size * size + column;
            sum += field[row * size + column] * field[next];
        }
    return sum / double(field.size());
}

// Without a fall of amplitudes neighbours are independent: their correlation has a deviation of 1/64.
TEST(FractalNoise, IsSmootherWithALargerExponent) {
    Rng rng(Hash(2));
    const double white = NeighbourCorrelation(FractalNoise(64, 0, 1, rng), 64, true),
                 pink = NeighbourCorrelation(FractalNoise(64, 1, 1, rng), 64, true),
                 smooth = NeighbourCorrelation(FractalNoise(64, 2, 1, rng), 64, true);
    EXPECT_NEAR(white, 0, 5. / 64);
    EXPECT_GT(pink, 0.4);
    EXPECT_GT(smooth, 0.9);
    const Field stretched = FractalNoise(64, 1, 8, rng);
    EXPECT_GT(NeighbourCorrelation(stretched, 64, true), NeighbourCorrelation(stretched, 64, false) + 0.1);
}

TEST(ProceduralMaterial, ValuesAreInRangeAndNormalsHaveAZ) {
    for (int family = 0; family < kNumFamilies; ++family)
        for (uint64_t seed = 0; seed < 20; ++seed) {
            const capture::Maps maps = ProceduralMaterial(Family(family), kSize, seed);
            for (const double v : maps.values) ASSERT_TRUE(v >= -1 && v <= 1) << FamilyName(Family(family));
            for (size_t i = 0; i < maps.NumTexels(); ++i)
                ASSERT_LT(
                    std::hypot(maps.Channel(capture::kNormal)[i], maps.Channel(capture::kNormal + 1)[i]), 1);
        }
}

TEST(ProceduralMaterial, SeedsTellMaterialsApart) {
    for (int family = 0; family < kNumFamilies; ++family) {
        const capture::Maps a = ProceduralMaterial(Family(family), kSize, 1);
        EXPECT_EQ(a.values, ProceduralMaterial(Family(family), kSize, 1).values);
        EXPECT_NE(a.values, ProceduralMaterial(Family(family), kSize, 2).values);
    }
    EXPECT_EQ(TrainingMaterial(kSize, 5).values, TrainingMaterial(kSize, 5).values);
}

/// Means of the slopes along x and y, and their root mean square. Those of a periodic height have mean 0.
std::array<double, 3> SlopeMeans(const capture::Maps& maps) {
    const auto x = maps.Channel(capture::kNormal), y = maps.Channel(capture::kNormal + 1);
    std::array<double, 3> means{};
    for (size_t i = 0; i < x.size(); ++i) {
        const double z = std::sqrt(1 - x[i] * x[i] - y[i] * y[i]), dx = -x[i] / z, dy = -y[i] / z;
        means[0] += dx / double(x.size());
        means[1] += dy / double(x.size());
        means[2] += (dx * dx + dy * dy) / double(x.size());
    }
    means[2] = std::sqrt(means[2]);
    return means;
}

TEST(ProceduralMaterial, NormalsAreThoseOfAPeriodicHeight) {
    for (int family = 0; family < kNumFamilies; ++family) {
        const auto means = SlopeMeans(ProceduralMaterial(Family(family), kSize, 3));
        EXPECT_NEAR(means[0], 0, 1e-6 + 1e-6 * means[2]) << FamilyName(Family(family));
        EXPECT_NEAR(means[1], 0, 1e-6 + 1e-6 * means[2]) << FamilyName(Family(family));
    }
}

// A cone of normals: turned about its middle it is the same.
TEST(QuarterTurn, TurnsNormalsAlong) {
    capture::Maps cone(kSize);
    for (int row = 0; row < kSize; ++row)
        for (int column = 0; column < kSize; ++column) {
            const double x = (column + 0.5) / kSize - 0.5, y = 0.5 - (row + 0.5) / kSize;
            const size_t i = size_t(row) * kSize + size_t(column);
            cone.Channel(capture::kNormal)[i] = x;
            cone.Channel(capture::kNormal + 1)[i] = y;
        }
    const capture::Maps turned = QuarterTurn(cone);
    for (size_t i = 0; i < cone.values.size(); ++i) EXPECT_NEAR(turned.values[i], cone.values[i], 1e-12);
    const capture::Maps maps = ProceduralMaterial(Family::Wood, kSize, 1);
    EXPECT_NE(QuarterTurn(maps).values, maps.values);
    EXPECT_EQ(QuarterTurn(QuarterTurn(QuarterTurn(QuarterTurn(maps)))).values, maps.values);
}

TEST(Shift, WrapsAround) {
    const capture::Maps maps = ProceduralMaterial(Family::Cells, kSize, 1),
                        shifted = Shift(maps, 3, kSize - 1);
    EXPECT_EQ(shifted.Channel(2)[3 * kSize + kSize - 1], maps.Channel(2)[0]);
    EXPECT_EQ(Shift(shifted, kSize - 3, 1).values, maps.values);
}

}  // namespace
}  // namespace lacquer::materialgan::procedural_test
