// Gaussians over slopes: densities, draws and products against sums over fine grids.
#include "gaussfit/lobe/gaussian.h"

#include <gtest/gtest.h>

#include <vector>

#include "pbrt/core/rng.h"
#include "support/statistics.h"

namespace lacquer::gaussfit::test {

using namespace lacquer::test;

namespace {

/// Precisions p and q along axes turned by `angle`, mean (x, y).
Gaussian2 Turned(float x, float y, float p, float q, float angle) {
    const float c = std::cos(angle), s = std::sin(angle);
    return {x, y, p * c * c + q * s * s, (p - q) * c * s, p * s * s + q * c * c};
}

/// As fitted lobes are: round, narrow, oblique, of the smallest alpha (0.005: precision 8e4), and grazing.
const Gaussian2 kGaussians[] = {Turned(0, 0, 1, 1, 0), Turned(0.3f, -0.5f, 20, 50, 0.4f),
                                Turned(-1, 2, 900, 3, 1.1f), Turned(0.6f, 0.1f, 8e4f, 2e4f, 2),
                                Turned(3, -4, 0.05f, 2e3f, 2.2f)};

/// Sum of f over a grid of +-7 standard deviations of g. Its error is below 1e-6 of the sum for functions as
/// smooth as g.
template <class Function>
double Integrate(const Gaussian2& g, const Function& f) {
    constexpr int kCells = 200;
    constexpr double kReach = 7, kStep = 2 * kReach / kCells;
    const Gaussian2::Factor l = g.Factorize();
    double sum = 0;
    for (int i = 0; i < kCells; ++i)
        for (int j = 0; j < kCells; ++j)
            sum +=
                f(g.FromStandard({float(-kReach + (i + 0.5) * kStep), float(-kReach + (j + 0.5) * kStep)}));
    return sum * kStep * kStep / double(l.Volume());
}

GaussianMixture MixtureOf(float weight, const Gaussian2& a, const Gaussian2& b) {
    GaussianMixture m;
    m.count = 2;
    m.parts = {a, b};
    m.weights = {weight, 1 - weight};
    return m;
}

TEST(Slope, IsTurnedBackOnBothSides) {
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 1000; ++i) {
        const Vec3 w = Normalize(Vec3(rng.Uniform() - 0.5f, rng.Uniform() - 0.5f, rng.Uniform() - 0.5f));
        const Vec3 again = DirectionOfSlope(SlopeOf(w), w.z);
        EXPECT_LT(Length(again - w), 4e-7f);
        EXPECT_LT(Length(DirectionOfSlope(SlopeOf(w), -w.z) + w), 4e-7f);
    }
}

// The solid angle of a small square of slopes, by the area of its image on the sphere.
TEST(Slope, AreaPerSolidAngleIsThatOfSmallSquares) {
    for (const Point2 s : {Point2(0, 0), Point2(0.5f, -1), Point2(3, 2)}) {
        constexpr float h = 1e-2f;
        const Vec3 dx = DirectionOfSlope(s + Point2(h, 0), 1) - DirectionOfSlope(s - Point2(h, 0), 1);
        const Vec3 dy = DirectionOfSlope(s + Point2(0, h), 1) - DirectionOfSlope(s - Point2(0, h), 1);
        const float solidAngle = Length(Cross(dx, dy));
        EXPECT_NEAR(solidAngle * SlopePerSolidAngle(DirectionOfSlope(s, 1)) / (4 * h * h), 1, 1e-3f);
    }
}

TEST(Gaussian2, DensityIntegratesToOneAndHasItsMoments) {
    for (const Gaussian2& g : kGaussians) {
        EXPECT_NEAR(Integrate(g, [&](Point2 s) { return double(g.Pdf(s)); }), 1, 1e-4);
        // Covariance times precision is the unit matrix.
        double cxx = 0, cxy = 0, cyy = 0;
        const auto moment = [&](auto&& power) {
            return Integrate(g, [&](Point2 s) {
                const double x = double(s.x) - double(g.meanX), y = double(s.y) - double(g.meanY);
                return double(g.Pdf(s)) * power(x, y);
            });
        };
        cxx = moment([](double x, double) { return x * x; });
        cxy = moment([](double x, double y) { return x * y; });
        cyy = moment([](double, double y) { return y * y; });
        EXPECT_NEAR(double(g.xx) * cxx + double(g.xy) * cxy, 1, 0.01);
        EXPECT_NEAR(double(g.xy) * cxy + double(g.yy) * cyy, 1, 0.01);
        EXPECT_NEAR((double(g.xx) * cxy + double(g.xy) * cyy) / std::sqrt(double(g.xx) / double(g.yy)), 0,
                    0.01);
    }
}

/// Counts of draws in squares of the standardised plane against the density's integral over them.
Outcome CompareDraws(const GaussianMixture& drawn, const GaussianMixture& density, uint64_t seed) {
    constexpr int kCells = 24, kDraws = 40000, kSub = 6;
    const Gaussian2& g = density.parts[0];
    const Gaussian2::Factor l = g.Factorize();
    std::vector<double> observed(kCells * kCells + 1), expected(kCells * kCells + 1);
    Rng rng(seed);
    const auto cell = [](float z) { return int(std::floor((z + 6) * (kCells / 12.f))); };
    for (int i = 0; i < kDraws; ++i) {
        const Point2 s = drawn.Draw(rng.Uniform2D());
        const float dx = s.x - g.meanX, dy = s.y - g.meanY;
        const int x = cell(l.xx * dx + l.yx * dy), y = cell(l.yy * dy);
        const bool isInside = x >= 0 && x < kCells && y >= 0 && y < kCells;
        observed[isInside ? size_t(y * kCells + x) : observed.size() - 1] += 1;
    }
    double inside = 0;
    constexpr double kStep = 12. / (kCells * kSub);
    for (int i = 0; i < kCells * kSub; ++i)
        for (int j = 0; j < kCells * kSub; ++j) {
            const Point2 s = g.FromStandard({float(-6 + (i + 0.5) * kStep), float(-6 + (j + 0.5) * kStep)});
            const double p = double(density.Pdf(s)) * kStep * kStep / double(l.Volume());
            expected[size_t(j / kSub * kCells + i / kSub)] += p * kDraws;
            inside += p;
        }
    expected.back() = std::max(0., 1 - inside) * kDraws;
    return ChiSquareTest(observed, expected);
}

// Power: 40000 draws find a mean that is off by 0.05 standard deviations (the control).
TEST(GaussianMixture, DrawsHaveTheirDensity) {
    const GaussianMixture cases[] = {GaussianMixture(kGaussians[1]), GaussianMixture(kGaussians[3]),
                                     MixtureOf(0.7f, kGaussians[1], Turned(0.5f, -0.3f, 8, 9, 0)),
                                     MixtureOf(0.01f, Turned(0, 0, 2, 2, 0), Turned(0.2f, 0.1f, 5, 3, 1))};
    for (size_t i = 0; i < std::size(cases); ++i)
        EXPECT_TRUE(Passes(FullTestName() + std::to_string(i), SidakAlpha(1e-3, int(std::size(cases))),
                           [&](uint64_t seed) { return CompareDraws(cases[i], cases[i], seed); }));
    Gaussian2 shifted = kGaussians[1];
    shifted.meanX += 0.05f / std::sqrt(shifted.xx);
    EXPECT_LT(CompareDraws(GaussianMixture(shifted), cases[0], SeedOf(FullTestName())).pValue, 1e-3);
}

TEST(Gaussian2, ProductIsProportionalAndScaleIsItsIntegral) {
    for (const Gaussian2& a : kGaussians) {
        for (const Gaussian2& b : kGaussians) {
            const Gaussian2 product = Multiply(a, b);
            const float exponent = LogScaleOfProduct(a, b, product);
            // Means of the two many deviations apart: both sides vanish in float.
            if (exponent < -30) continue;
            const double scale = std::exp(double(exponent)) / (2 * M_PI);
            const double integral =
                Integrate(product, [&](Point2 s) { return double(a.Pdf(s)) * double(b.Pdf(s)); });
            EXPECT_NEAR(integral / scale, 1, 0.02) << exponent;
            for (const Point2 z : {Point2(0, 0), Point2(1, 0), Point2(-1, 2), Point2(0, -2)}) {
                const Point2 s = product.FromStandard(z);
                EXPECT_NEAR(double(a.Pdf(s)) * double(b.Pdf(s)) / (scale * double(product.Pdf(s))), 1, 0.05);
            }
        }
    }
}

TEST(GaussianMixture, ProductIsTheNormalisedProduct) {
    const GaussianMixture a = MixtureOf(0.7f, kGaussians[1], Turned(0.5f, -0.3f, 8, 9, 0));
    const GaussianMixture b = MixtureOf(0.2f, Turned(0.4f, -0.4f, 30, 10, 1), Turned(0, 0, 2, 3, 0));
    const GaussianMixtureProduct product = Multiply(a, b);
    ASSERT_EQ(product.count, 4);
    const Gaussian2 wide = Turned(0.3f, -0.4f, 1, 1, 0);
    const double norm = Integrate(wide, [&](Point2 s) { return double(a.Pdf(s)) * double(b.Pdf(s)); });
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 100; ++i) {
        const Point2 s = product.Draw(rng.Uniform2D());
        EXPECT_NEAR(double(a.Pdf(s)) * double(b.Pdf(s)) / norm / double(product.Pdf(s)), 1, 1e-3);
    }
}

TEST(GaussianMixture, ProductsOfFarPartsStayFinite) {
    const Gaussian2 left = Turned(-30, 0, 8e4f, 8e4f, 0), right = Turned(30, 5, 8e4f, 1e-3f, 0.3f);
    const GaussianMixtureProduct product =
        Multiply(MixtureOf(0.5f, left, Turned(-31, 0, 8e4f, 8e4f, 0)), MixtureOf(0.5f, right, right));
    float sum = 0;
    for (size_t i = 0; i < 4; ++i) sum += product.weights[i];
    EXPECT_NEAR(sum, 1, 1e-5f);
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 1000; ++i) {
        const Point2 s = product.Draw(rng.Uniform2D());
        EXPECT_TRUE(std::isfinite(s.x) && std::isfinite(s.y));
        EXPECT_GT(product.Pdf(s), 0);
    }
}

// A precision that rounding made indefinite still draws what its density says.
TEST(Gaussian2, SurvivesLostDefiniteness) {
    Gaussian2 g{0, 0, 1e4f, 1e4f, 1e4f};
    g.xy = std::nextafter(g.xy, 2e4f);
    EXPECT_NEAR(Integrate(g, [&](Point2 s) { return double(g.Pdf(s)); }), 1, 1e-2);
}

}  // namespace
}  // namespace lacquer::gaussfit::test
