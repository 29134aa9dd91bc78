// Slopes against directions, and the small matrices over them against sums in double precision.
#include "pbrt/scattering/slopes.h"

#include <gtest/gtest.h>

#include <type_traits>

#include "pbrt/core/rng.h"
#include "support/statistics.h"

namespace lacquer::test::slopes_test {
namespace {

// A Vec3 that turns into two of its numbers without a word has led to wrong dot products.
static_assert(!std::is_convertible_v<Vec3, Slope> && !std::is_constructible_v<Slope, Vec3>);
static_assert(std::is_constructible_v<Vec2, Vec3>, "negative control: glm's vectors do turn into each other");

TEST(Slope, IsTurnedBackOnBothSides) {
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 1000; ++i) {
        const Vec3 w = Normalize(Vec3(rng.Uniform() - 0.5f, rng.Uniform() - 0.5f, rng.Uniform() - 0.5f));
        const Vec3 again = DirectionOf(SlopeOf(w), w.z);
        EXPECT_LT(Length(again - w), 4e-7f);
        EXPECT_LT(Length(DirectionOf(SlopeOf(w), -w.z) + w), 4e-7f);
    }
}

// The solid angle of a small square of slopes, by the area of its image on the sphere.
TEST(Slope, AreaPerSolidAngleIsThatOfSmallSquares) {
    for (const Slope s : {Slope{0, 0}, Slope{0.5f, -1}, Slope{3, 2}}) {
        constexpr float h = 1e-2f;
        const Vec3 dx = DirectionOf(s + Slope{h, 0}, 1) - DirectionOf(s - Slope{h, 0}, 1);
        const Vec3 dy = DirectionOf(s + Slope{0, h}, 1) - DirectionOf(s - Slope{0, h}, 1);
        const float solidAngle = Length(Cross(dx, dy));
        EXPECT_NEAR(solidAngle * SlopePerSolidAngle(DirectionOf(s, 1)) / (4 * h * h), 1, 1e-3f);
    }
}

// Grazing and steep directions, and slopes beyond what a cosine in a float can tell from the horizon.
TEST(Slope, DirectionsStayUnitAtTheHorizon) {
    for (const float length : {0.f, 1e-20f, 1e-6f, 1.f, 1e4f, 1e12f}) {
        const Vec3 w = DirectionOf(Slope{0.6f * length, -0.8f * length}, -1);
        EXPECT_NEAR(Length(w), 1, 3e-7f) << length;
        EXPECT_LT(w.z, 0) << length;
        EXPECT_NEAR(SlopeOf(w).x / (0.6f * length + 1e-30f), length > 0 ? 1 : 0, 1e-6f) << length;
    }
}

/// Rows of a product of 2x2 matrices in double precision.
std::array<double, 4> Product(const std::array<double, 4>& a, const std::array<double, 4>& b) {
    return {a[0] * b[0] + a[1] * b[2], a[0] * b[1] + a[1] * b[3], a[2] * b[0] + a[3] * b[2],
            a[2] * b[1] + a[3] * b[3]};
}
std::array<double, 4> Rows(const Matrix2& m) {
    return {double(m.xx), double(m.xy), double(m.yx), double(m.yy)};
}
std::array<double, 4> Rows(const Symmetric2& m) {
    return {double(m.xx), double(m.xy), double(m.xy), double(m.yy)};
}
std::array<double, 4> Transposed(const std::array<double, 4>& m) { return {m[0], m[2], m[1], m[3]}; }
/// Largest difference of two matrices over the largest number in the second one.
double Difference(const std::array<double, 4>& a, const std::array<double, 4>& b) {
    double difference = 0, largest = 0;
    for (size_t i = 0; i < 4; ++i) {
        difference = std::max(difference, std::abs(a[i] - b[i]));
        largest = std::max(largest, std::abs(b[i]));
    }
    return difference / largest;
}

struct Matrices {
    Matrix2 a, b;
    Symmetric2 s;
    Slope v;
};
Matrices SampleMatrices(Rng& rng) {
    const auto draw = [&] { return 2 * rng.Uniform() - 1; };
    const Matrix2 root{1.5f + draw(), draw(), draw(), 1.5f + draw()};
    return {{draw(), draw(), draw(), draw()},
            {1.5f + draw(), draw(), draw(), 1.5f + draw()},
            root.Gram(),
            {draw(), draw()}};
}

// Sums of four products of numbers below 3: a few roundings of the largest.
constexpr double kRounding = 8 * 6e-8;

TEST(Matrices, ProductsAreThoseOfTheirRows) {
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 200; ++i) {
        const Matrices m = SampleMatrices(rng);
        const auto a = Rows(m.a), b = Rows(m.b), s = Rows(m.s);
        EXPECT_LT(Difference(Rows(m.a * m.b), Product(a, b)), kRounding);
        EXPECT_LT(Difference(Rows(m.a.PushForward(m.s)), Product(Product(a, s), Transposed(a))), kRounding);
        EXPECT_LT(Difference(Rows(m.a.PullBack(m.s)), Product(Product(Transposed(a), s), a)), kRounding);
        EXPECT_LT(Difference(Rows(m.a.Gram()), Product(Transposed(a), a)), kRounding);
        EXPECT_NEAR(Dot(m.v, m.a * m.v), Dot(m.a.TransposeTimes(m.v), m.v), 1e-6f);
        // Negative control: the two congruences are told apart.
        EXPECT_GT(Difference(Rows(m.a.PushForward(m.s)), Product(Product(Transposed(a), s), a)), 1e-4);
    }
}

TEST(Matrices, InversesUndo) {
    constexpr std::array<double, 4> kUnit = {1, 0, 0, 1};
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 200; ++i) {
        const Matrices m = SampleMatrices(rng);
        // Condition numbers are below 1e3.
        if (!(std::abs(m.b.Determinant()) > 0.05f && m.s.Determinant() > 0.05f)) continue;
        EXPECT_LT(Difference(Product(Rows(m.b), Rows(m.b.Inverse())), kUnit), 1e3 * kRounding);
        EXPECT_LT(Difference(Product(Rows(m.s), Rows(m.s.Inverse())), kUnit), 1e3 * kRounding);
    }
}

// Covariances of the smallest and of absurd alphas, and one that rounding made singular.
TEST(Matrices, InversesOfThinCovariancesAreFiniteAndPositive) {
    for (const float alpha2 : {1e-12f, 1e-4f, 1.f, 1e8f})
        for (const float ratio : {1.f, 1e-3f, 1e-6f}) {
            const Symmetric2 turned =
                Symmetric2{}.PlusSquare(alpha2, {0.6f, 0.8f}).PlusSquare(ratio * alpha2, {-0.8f, 0.6f});
            const Symmetric2 inverse = turned.Inverse();
            EXPECT_TRUE(inverse.xx > 0 && inverse.yy > 0 && std::isfinite(inverse.Trace())) << alpha2;
            EXPECT_GE(inverse.Trace() * alpha2, 0.99f);
        }
}

TEST(Matrices, AScaledShearIsOneAndADyad) {
    const Slope a{0.3f, -0.7f}, b{2, 0.5f};
    const Matrix2 m = Matrix2::ScaledShear(3, a, b);
    const Slope v{-1, 4}, expected = 3 * (v + a * Dot(b, v)), found = m * v;
    EXPECT_NEAR(found.x, expected.x, 1e-5f);
    EXPECT_NEAR(found.y, expected.y, 1e-5f);
}

}  // namespace
}  // namespace lacquer::test::slopes_test
