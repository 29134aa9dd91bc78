#include "estimate/fourier/fft.h"

#include <gtest/gtest.h>

#include <numbers>

#include "estimate/gradient_check.h"

namespace lacquer::estimate::fft_test {
namespace {

double LargestGap(std::span<const double> a, std::span<const double> b) {
    double gap = 0;
    for (size_t i = 0; i < a.size(); ++i) gap = std::max(gap, std::abs(a[i] - b[i]));
    return gap;
}

ComplexGrid RandomHalf(const Fft2& fft, uint64_t seed) {
    ComplexGrid half = fft.MakeHalf();
    const auto numbers = RandomNumbers(2 * half.re.size(), seed, -1, 1);
    for (int row = 0; row < half.rows; ++row)
        for (int k = 0; k < half.columns; ++k) {
            const size_t i = half.Index(row, k);
            half.re[i] = numbers[2 * i];
            half.im[i] = numbers[2 * i + 1];
        }
    return half;
}

double DotHalf(const ComplexGrid& a, const ComplexGrid& b) { return Dot(a.re, b.re) + Dot(a.im, b.im); }

// Sizes with factors 2, 3, 5 and 7, odd ones, and ones that are no multiple of the eight rows at once.
constexpr int kSizes[] = {6, 7, 8, 10, 16, 30, 35};

TEST(Fft, IsTheSumThatDefinesIt) {
    for (const int n : kSizes) {
        Fft2 fft(n);
        const auto image = RandomNumbers(size_t(n * n), uint64_t(n), -1, 1);
        ComplexGrid half = fft.MakeHalf();
        fft.Forward(image, &half);
        for (int ky = 0; ky < n; ++ky)
            for (int kx = 0; kx <= n / 2; ++kx) {
                double re = 0, im = 0;
                for (int y = 0; y < n; ++y)
                    for (int x = 0; x < n; ++x) {
                        const double angle = -2 * std::numbers::pi * (kx * x + ky * y) / n;
                        re += image[size_t(y * n + x)] * std::cos(angle);
                        im += image[size_t(y * n + x)] * std::sin(angle);
                    }
                // Sums of n^2 numbers of size one.
                EXPECT_NEAR(half.re[half.Index(ky, kx)], re, 1e-14 * n * n) << n;
                EXPECT_NEAR(half.im[half.Index(ky, kx)], im, 1e-14 * n * n) << n;
            }
    }
}

TEST(Fft, InverseGivesTheImageBack) {
    for (const int n : kSizes) {
        Fft2 fft(n);
        const auto image = RandomNumbers(size_t(n * n), uint64_t(n), -1, 1);
        std::vector<double> back(image.size());
        ComplexGrid half = fft.MakeHalf();
        fft.Forward(image, &half);
        fft.Inverse(&half, back);
        for (double& v : back) v /= n * n;
        EXPECT_LT(LargestGap(image, back), 1e-14) << n;
    }
}

// <A x, y> = <x, A* y> for both directions. The control: the inverse is not the adjoint, as it counts most
// entries twice.
TEST(Fft, AdjointsAreAdjoint) {
    for (const int n : kSizes) {
        Fft2 fft(n);
        const auto image = RandomNumbers(size_t(n * n), uint64_t(n), -1, 1);
        ComplexGrid spectrum = fft.MakeHalf();
        fft.Forward(image, &spectrum);
        const ComplexGrid by = RandomHalf(fft, 5);
        std::vector<double> byImage(image.size()), wrong(image.size());
        ComplexGrid copy = by;
        fft.ForwardAdjoint(&copy, byImage);
        const double left = DotHalf(spectrum, by);
        EXPECT_NEAR(left, Dot(image, byImage), 1e-13 * n * n * n) << n;
        copy = by;
        fft.Inverse(&copy, wrong);
        EXPECT_GT(std::abs(left - Dot(image, wrong)), 1e-3) << n;

        ComplexGrid input = by;
        fft.Inverse(&input, byImage);
        ComplexGrid byHalf = fft.MakeHalf();
        fft.InverseAdjoint(image, &byHalf);
        // Imaginary parts of frequencies that are their own mirror image count for nothing.
        EXPECT_NEAR(Dot(byImage, image), DotHalf(by, byHalf), 1e-13 * n * n * n) << n;
    }
}

TEST(Fft, ComplexTransformsAgreeWithRealOnes) {
    for (const int n : kSizes) {
        Fft2 fft(n);
        const auto image = RandomNumbers(size_t(n * n), uint64_t(n), -1, 1);
        ComplexGrid half = fft.MakeHalf(), full = fft.MakeFull();
        for (int y = 0; y < n; ++y)
            for (int x = 0; x < n; ++x) full.re[full.Index(y, x)] = image[size_t(y * n + x)];
        fft.Forward(image, &half);
        fft.ForwardComplex(&full);
        for (int ky = 0; ky < n; ++ky)
            for (int kx = 0; kx <= n / 2; ++kx) {
                EXPECT_NEAR(half.re[half.Index(ky, kx)], full.re[full.Index(ky, kx)], 1e-14 * n * n);
                EXPECT_NEAR(half.im[half.Index(ky, kx)], full.im[full.Index(ky, kx)], 1e-14 * n * n);
            }
        fft.InverseComplex(&full);
        EXPECT_NEAR(full.re[full.Index(n - 1, n / 2)] / (n * n), image[size_t((n - 1) * n + n / 2)], 1e-14);
        EXPECT_NEAR(full.im[full.Index(n - 1, n / 2)] / (n * n), 0, 1e-14);
    }
}

}  // namespace
}  // namespace lacquer::estimate::fft_test
