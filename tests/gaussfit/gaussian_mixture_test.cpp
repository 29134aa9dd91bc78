// Mixtures of Gaussians over slopes: draws and products against sums over fine grids.
#include "gaussfit/lobe/gaussian_mixture.h"

#include <gtest/gtest.h>

#include <vector>

#include "pbrt/core/rng.h"
#include "scattering/gaussian_grid.h"
#include "support/statistics.h"

namespace lacquer::gaussfit::test::gaussian_mixture_test {

using namespace lacquer::test;

namespace {

GaussianMixture MixtureOf(float weight, const Gaussian2& a, const Gaussian2& b) {
    GaussianMixture m;
    m.count = 2;
    m.parts = {a, b};
    m.weights = {weight, 1 - weight};
    return m;
}

/// Counts of draws in squares of the standardised plane against the density's integral over them.
Outcome CompareSamples(const GaussianMixture& drawn, const GaussianMixture& density, uint64_t seed) {
    constexpr int kCells = 24, kSamples = 40000, kSub = 6;
    const Gaussian2& g = density.parts[0];
    const CholeskyFactor l = g.Factorize();
    std::vector<double> observed(kCells * kCells + 1), expected(kCells * kCells + 1);
    Rng rng(seed);
    const auto cell = [](float z) { return int(std::floor((z + 6) * (kCells / 12.f))); };
    for (int i = 0; i < kSamples; ++i) {
        const Slope s = drawn.Sample(rng.Uniform2D());
        const Slope normal = l.ToStandard(s - g.mean);
        const int x = cell(normal.x), y = cell(normal.y);
        const bool isInside = x >= 0 && x < kCells && y >= 0 && y < kCells;
        observed[isInside ? size_t(y * kCells + x) : observed.size() - 1] += 1;
    }
    double inside = 0;
    constexpr double kStep = 12. / (kCells * kSub);
    for (int i = 0; i < kCells * kSub; ++i)
        for (int j = 0; j < kCells * kSub; ++j) {
            const Slope s =
                g.mean + l.FromStandard({float(-6 + (i + 0.5) * kStep), float(-6 + (j + 0.5) * kStep)});
            const double p = double(density.Pdf(s)) * kStep * kStep / double(l.Volume());
            expected[size_t(j / kSub * kCells + i / kSub)] += p * kSamples;
            inside += p;
        }
    expected.back() = std::max(0., 1 - inside) * kSamples;
    return ChiSquareTest(observed, expected);
}

// Power: 40000 draws find a mean that is off by 0.05 standard deviations (the control).
TEST(GaussianMixture, DrawsHaveTheirDensity) {
    const GaussianMixture cases[] = {GaussianMixture(kGaussians[1]), GaussianMixture(kGaussians[3]),
                                     MixtureOf(0.7f, kGaussians[1], Turned(0.5f, -0.3f, 8, 9, 0)),
                                     MixtureOf(0.01f, Turned(0, 0, 2, 2, 0), Turned(0.2f, 0.1f, 5, 3, 1))};
    for (size_t i = 0; i < std::size(cases); ++i)
        EXPECT_TRUE(Passes(FullTestName() + std::to_string(i), SidakAlpha(1e-3, int(std::size(cases))),
                           [&](uint64_t seed) { return CompareSamples(cases[i], cases[i], seed); }));
    Gaussian2 shifted = kGaussians[1];
    shifted.mean.x += 0.05f / std::sqrt(shifted.precision.xx);
    EXPECT_LT(CompareSamples(GaussianMixture(shifted), cases[0], SeedOf(FullTestName())).pValue, 1e-3);
}

TEST(GaussianMixture, ProductIsTheNormalisedProduct) {
    const GaussianMixture a = MixtureOf(0.7f, kGaussians[1], Turned(0.5f, -0.3f, 8, 9, 0));
    const GaussianMixture b = MixtureOf(0.2f, Turned(0.4f, -0.4f, 30, 10, 1), Turned(0, 0, 2, 3, 0));
    const GaussianMixtureProduct product = Multiply(a, b);
    ASSERT_EQ(product.count, 4);
    const Gaussian2 wide = Turned(0.3f, -0.4f, 1, 1, 0);
    const double norm = Integrate(wide, [&](Slope s) { return double(a.Pdf(s)) * double(b.Pdf(s)); });
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 100; ++i) {
        const Slope s = product.Sample(rng.Uniform2D());
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
        const Slope s = product.Sample(rng.Uniform2D());
        EXPECT_TRUE(std::isfinite(s.x) && std::isfinite(s.y));
        EXPECT_GT(product.Pdf(s), 0);
    }
}

}  // namespace
}  // namespace lacquer::gaussfit::test::gaussian_mixture_test
