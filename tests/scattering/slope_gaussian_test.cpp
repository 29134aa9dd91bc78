// Gaussians over slopes: densities, draws and products against sums over fine grids.
#include "pbrt/scattering/slope_gaussian.h"

#include <gtest/gtest.h>

#include "pbrt/core/rng.h"
#include "scattering/gaussian_grid.h"
#include "support/statistics.h"

namespace lacquer::test::slope_gaussian_test {
namespace {

// ---- Draws --------------------------------------------------------------------------------------------

/// Moments of points, up to the fourth.
struct PointMoments {
    double x = 0, y = 0, xx = 0, xy = 0, yy = 0, xxxx = 0, xxyy = 0;

    void Add(Slope p, double weight) {
        const double a = double(p.x), b = double(p.y);
        x += weight * a, y += weight * b;
        xx += weight * a * a, xy += weight * a * b, yy += weight * b * b;
        xxxx += weight * a * a * a * a, xxyy += weight * a * a * b * b;
    }
};
/// Of draw(u), u being the middles of the cells of a grid. Its error is that of the outermost cells, 1/n of
/// the square of a radius.
template <class Draw>
PointMoments MomentsOver(const Draw& draw) {
    constexpr int kCells = 1000;
    PointMoments moments;
    for (int i = 0; i < kCells; ++i)
        for (int j = 0; j < kCells; ++j)
            moments.Add(draw(Point2((float(i) + 0.5f) / kCells, (float(j) + 0.5f) / kCells)),
                        1. / Sqr(double(kCells)));
    return moments;
}

// Power: 0.5 % of a standard deviation.
TEST(StandardNormal, DrawsHaveItsMoments) {
    const PointMoments m = MomentsOver([](Point2 u) { return SampleStandardNormal(u).point; });
    EXPECT_NEAR(m.x, 0, 1e-3);
    EXPECT_NEAR(m.y, 0, 1e-3);
    EXPECT_NEAR(m.xx, 1, 3e-3);
    EXPECT_NEAR(m.xy, 0, 1e-3);
    EXPECT_NEAR(m.yy, 1, 3e-3);
    EXPECT_NEAR(m.xxxx, 3, 5e-2);
    EXPECT_NEAR(m.xxyy, 1, 2e-2);
    // Negative control: 0.5 % wider.
    const PointMoments wide = MomentsOver([](Point2 u) { return 1.005f * SampleStandardNormal(u).point; });
    EXPECT_GT(std::abs(wide.xx - 1), 3e-3);
}

TEST(StandardNormal, KnowsTheSquareOfItsLength) {
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 1000; ++i) {
        const Point2 u = rng.Uniform2D();
        const StandardNormalSample sample = SampleStandardNormal(u);
        EXPECT_NEAR(Dot(sample.point, sample.point), sample.square, 1e-6f * (1 + sample.square));
        EXPECT_NEAR(std::exp(-0.5f * sample.square), 1 - u.x, 1e-6f);
    }
    // The ends of the generator's range.
    EXPECT_EQ(SampleStandardNormal({0, 0.3f}).square, 0);
    EXPECT_TRUE(std::isfinite(SampleStandardNormal({OneMinusEpsilon, OneMinusEpsilon}).square));
}

/// What draws of exp(gradient' d - d' P d / 2) should have: mean at + P^-1 gradient, covariance P^-1.
void CheckDraws(Slope at, const Symmetric2& p, Slope gradient) {
    const FactoredGaussian2 gaussian(at, p, gradient);
    ASSERT_TRUE(gaussian.IsValid());
    const double det = double(p.xx) * double(p.yy) - double(p.xy) * double(p.xy);
    const double cxx = double(p.yy) / det, cxy = -double(p.xy) / det, cyy = double(p.xx) / det;
    const double dx = cxx * double(gradient.x) + cxy * double(gradient.y),
                 dy = cxy * double(gradient.x) + cyy * double(gradient.y);
    const double sx = std::sqrt(cxx), sy = std::sqrt(cyy);
    const PointMoments m = MomentsOver([&](Point2 u) { return gaussian.Sample(u).slope - at; });
    EXPECT_NEAR((m.x - dx) / sx, 0, 2e-3 + 1e-5 * std::abs(dx) / sx);
    EXPECT_NEAR((m.y - dy) / sy, 0, 2e-3 + 1e-5 * std::abs(dy) / sy);
    EXPECT_NEAR((m.xx - dx * dx) / (sx * sx), 1, 5e-3);
    EXPECT_NEAR((m.yy - dy * dy) / (sy * sy), 1, 5e-3);
    EXPECT_NEAR((m.xy - dx * dy) / (sx * sy), cxy / (sx * sy), 5e-3);
}

// Alphas from 0.001 to 100, round and oblique, means a few deviations away.
TEST(FactoredGaussian2, DrawsHaveTheMeanAndTheCovariance) {
    for (const float alpha : {1e-3f, 0.1f, 1.f, 100.f}) {
        const float p = 2 / Sqr(alpha);
        for (const Symmetric2& shape :
             {Symmetric2{1, 0, 1}, Symmetric2{1, 0.9f, 1}, Symmetric2{3, -0.4f, 0.1f}})
            CheckDraws({}, shape * p, {0.5f * std::sqrt(p), -std::sqrt(p)});
    }
}

TEST(FactoredGaussian2, DrawsSayTheirDensity) {
    Rng rng(SeedOf(FullTestName()));
    for (const Gaussian2& g : kGaussians) {
        const FactoredGaussian2 factored(g.mean, g.precision);
        for (int i = 0; i < 1000; ++i) {
            const Point2 u = rng.Uniform2D();
            const FactoredGaussian2::SlopeSample sample = factored.Sample(u);
            // A slope of size 3 in a float, in units of deviations of 0.003 and of the exponent.
            EXPECT_NEAR(sample.pdf / factored.Pdf(sample.slope), 1, 2e-3);
            EXPECT_NEAR(g.Pdf(sample.slope) / factored.Pdf(sample.slope), 1, 1e-4);
            const Slope same = g.Sample(u) - sample.slope;
            EXPECT_LT(Dot(same, same), 1e-10f * (1 + Dot(g.mean, g.mean)));
        }
        // Negative control: a factor of the density that forgets a half of one axis is 2 for all draws.
        const FactoredGaussian2 wrong(g.mean, {g.precision.xx, g.precision.xy, 1.02f * g.precision.yy});
        EXPECT_GT(
            std::abs(factored.Sample({0.5f, 0.5f}).pdf / wrong.Pdf(factored.Sample({0.5f, 0.5f}).slope) - 1),
            2e-3);
    }
}

TEST(FactoredGaussian2, KnowsWhenItIsNone) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_TRUE(FactoredGaussian2({}, {1e-12f, 0, 1e12f}).IsValid());
    EXPECT_FALSE(FactoredGaussian2({}, {0, 0, 1}).IsValid());
    EXPECT_FALSE(FactoredGaussian2({}, {1, 0, 0}).IsValid());
    EXPECT_FALSE(FactoredGaussian2({}, {nan, 0, 1}).IsValid());
    EXPECT_FALSE(FactoredGaussian2({}, {1, nan, 1}).IsValid());
    EXPECT_FALSE(FactoredGaussian2({nan, 0}, {1, 0, 1}).IsValid());
    EXPECT_FALSE(FactoredGaussian2({}, {1, 0, 1}, {nan, 0}).IsValid());
    EXPECT_FALSE(FactoredGaussian2({}, {-1, 0, 1}).IsValid());
}

// ---- Densities and products ---------------------------------------------------------------------------

TEST(Gaussian2, DensityIntegratesToOneAndHasItsMoments) {
    for (const Gaussian2& g : kGaussians) {
        EXPECT_NEAR(Integrate(g, [&](Slope s) { return double(g.Pdf(s)); }), 1, 1e-4);
        // Covariance times precision is the unit matrix.
        double cxx = 0, cxy = 0, cyy = 0;
        const auto moment = [&](auto&& power) {
            return Integrate(g, [&](Slope s) {
                const double x = double(s.x) - double(g.mean.x), y = double(s.y) - double(g.mean.y);
                return double(g.Pdf(s)) * power(x, y);
            });
        };
        cxx = moment([](double x, double) { return x * x; });
        cxy = moment([](double x, double y) { return x * y; });
        cyy = moment([](double, double y) { return y * y; });
        EXPECT_NEAR(double(g.precision.xx) * cxx + double(g.precision.xy) * cxy, 1, 0.01);
        EXPECT_NEAR(double(g.precision.xy) * cxy + double(g.precision.yy) * cyy, 1, 0.01);
        EXPECT_NEAR((double(g.precision.xx) * cxy + double(g.precision.xy) * cyy) /
                        std::sqrt(double(g.precision.xx) / double(g.precision.yy)),
                    0, 0.01);
    }
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
                Integrate(product, [&](Slope s) { return double(a.Pdf(s)) * double(b.Pdf(s)); });
            EXPECT_NEAR(integral / scale, 1, 0.02) << exponent;
            for (const Slope z : {Slope{0, 0}, Slope{1, 0}, Slope{-1, 2}, Slope{0, -2}}) {
                const Slope s = product.mean + product.Factorize().FromStandard(z);
                EXPECT_NEAR(double(a.Pdf(s)) * double(b.Pdf(s)) / (scale * double(product.Pdf(s))), 1, 0.05);
            }
        }
    }
}

// A precision that rounding made indefinite still draws what its density says.
TEST(Gaussian2, SurvivesLostDefiniteness) {
    Gaussian2 g{{}, {1e4f, 1e4f, 1e4f}};
    g.precision.xy = std::nextafter(g.precision.xy, 2e4f);
    EXPECT_NEAR(Integrate(g, [&](Slope s) { return double(g.Pdf(s)); }), 1, 1e-2);
}

// Negative control of the products: a mean that is off by a twentieth of a deviation.
TEST(Gaussian2, AProductWithAWrongMeanIsFound) {
    const Gaussian2 &a = kGaussians[0], &b = kGaussians[1];
    Gaussian2 product = Multiply(a, b);
    const Slope s = product.mean + product.Factorize().FromStandard({-1, 2});
    const double right = double(a.Pdf(s)) * double(b.Pdf(s)) / double(product.Pdf(s));
    product.mean.y += 0.05f / std::sqrt(product.precision.yy);
    EXPECT_GT(std::abs(double(a.Pdf(s)) * double(b.Pdf(s)) / double(product.Pdf(s)) / right - 1), 0.05);
}

}  // namespace
}  // namespace lacquer::test::slope_gaussian_test
