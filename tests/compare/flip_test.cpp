// FLIP against closed forms, and against numbers of the authors' steps.
//
// The numbers were made once with a separate program in double precision: the steps of the authors' NumPy
// code (NVlabs/flip on GitHub, python/flip_api.py, 2021), with its filters as direct sums over
// two-dimensional kernels. It and this implementation share neither the filters (separable here) nor the
// precision. They agreed to 4e-6 in every pixel; the tests allow 2e-5.
#include "compare/flip.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace lacquer::compare::flip_test {
namespace {

constexpr int kWidth = 64, kHeight = 48;
constexpr double kAgreement = 2e-5;

Image Uniform(RGB rgb) {
    Image image({8, 8}, {"R", "G", "B"});
    for (size_t i = 0; i < image.Pixels().size(); ++i) image.Pixels()[i] = rgb[int(i % 3)];
    return image;
}

struct Images {
    Image image, reference;
};

/// Waves and a ramp; the image has one wave shifted, dark dots in another, and a white pixel.
Images Patterns() {
    Image image({kWidth, kHeight}, {"R", "G", "B"}), reference = image;
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            const double wave = 0.5 * std::cos(0.2 * y + 0.1 * x), dot = (x + y) % 8 == 0 ? 0.5 : 1.0;
            const double r[3] = {0.5 + 0.5 * std::sin(0.3 * x), x / 63.0, 0.5 + wave};
            const double t[3] = {0.5 + 0.5 * std::sin(0.3 * x + 0.4), x / 63.0, 0.5 + wave * dot};
            const bool white = x == 20 && y == 30;
            for (int c = 0; c < 3; ++c) {
                reference.Set({x, y}, c, float(r[c]));
                image.Set({x, y}, c, white ? 1 : float(t[c]));
            }
        }
    return {image, reference};
}

/// The same reference over eight stops; the image has stripes of 30 % and a very bright pixel.
Images BrightPatterns() {
    Images patterns = Patterns();
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
            for (int c = 0; c < 3; ++c) {
                const double scale = std::exp2(x / 8.0 - 3), stripe = 1 + 0.3 * std::sin(0.5 * x + 0.7 * y);
                const auto value = float(double(patterns.reference.Get({x, y}, c)) * scale);
                const bool firefly = x == 20 && y == 30;
                patterns.reference.Set({x, y}, c, value);
                patterns.image.Set({x, y}, c, firefly ? 100 : float(double(value) * stripe));
            }
    return patterns;
}

double Mean(const Image& map) {
    return std::accumulate(map.Pixels().begin(), map.Pixels().end(), 0.0) / double(map.Pixels().size());
}

double At(const Image& map, int x, int y) { return double(map.Get({x, y}, 0)); }

TEST(Flip, EqualImagesDoNotDiffer) {
    const Images patterns = BrightPatterns();
    EXPECT_EQ(Mean(LdrFlip(patterns.reference, patterns.reference)), 0);
    EXPECT_EQ(Mean(HdrFlip(patterns.reference, patterns.reference, HdrFlipExposures(patterns.reference))), 0);
}

TEST(Flip, GreenAndBlueDifferMost) {
    EXPECT_NEAR(At(LdrFlip(Uniform({0, 1, 0}), Uniform({0, 0, 1})), 4, 4), 1, 1e-5);
}

TEST(Flip, UniformGreysHaveTheClosedForm) {
    // Filters leave them alone and find no features: what is left is the difference of lightness, 100 from
    // black to white, to the power 0.7, over that of green and blue, 0.4 of which becomes 0.95. In floats the
    // filters find features of some 1e-8, whose square root goes into the exponent.
    constexpr double kUniform = 1e-4;
    EXPECT_NEAR(At(LdrFlip(Uniform(RGB(0)), Uniform(RGB(1))), 4, 4), 0.9673797634, kUniform);
    EXPECT_NEAR(At(LdrFlip(Uniform(RGB(0.2f)), Uniform(RGB(0.3f))), 4, 4), 0.2846757574, kUniform);
    // Below the knee, ratios do not depend on green and blue.
    const auto lightness = [](double grey) { return 116 * std::cbrt(grey) - 16; };
    const double ratio =
        std::pow((lightness(0.3) - lightness(0.2)) / (lightness(0.25) - lightness(0.2)), 0.7);
    const double small = At(LdrFlip(Uniform(RGB(0.2f)), Uniform(RGB(0.25f))), 4, 4);
    EXPECT_NEAR(0.2846757574 / small, ratio, 2 * ratio * kUniform / small);
}

TEST(Flip, LdrAgreesWithTheAuthorsSteps) {
    const Images patterns = Patterns();
    const Image map = LdrFlip(patterns.image, patterns.reference);
    EXPECT_NEAR(Mean(map), 0.29543444, kAgreement);
    EXPECT_NEAR(At(map, 0, 0), 0.30864915, kAgreement) << "a corner";
    EXPECT_NEAR(At(map, 20, 30), 0.43593187, kAgreement) << "the white pixel";
    EXPECT_NEAR(At(map, 24, 30), 0.25299112, kAgreement) << "beside it";
    EXPECT_NEAR(At(map, 63, 47), 0.36585447, kAgreement) << "the last pixel";
}

TEST(Flip, NegativeControlFiltersTwoPerCentWiderAreNoticed) {
    const Images patterns = Patterns();
    // Most at the white pixel, a point that filters spread.
    const Image map = LdrFlip(patterns.image, patterns.reference, 1.02f * kFlipPixelsPerDegree);
    EXPECT_GT(std::abs(At(map, 20, 30) - 0.43593187), 5 * kAgreement);
}

TEST(Flip, HdrAgreesWithTheAuthorsSteps) {
    const Images patterns = BrightPatterns();
    const FlipExposures exposures = HdrFlipExposures(patterns.reference);
    EXPECT_NEAR(double(exposures.start), -3.63818434, 1e-5);
    EXPECT_NEAR(double(exposures.stop), 1.16302907, 1e-5);
    EXPECT_EQ(exposures.count, 5);
    const Image map = HdrFlip(patterns.image, patterns.reference, exposures);
    EXPECT_NEAR(Mean(map), 0.19320500, kAgreement);
    EXPECT_NEAR(At(map, 0, 0), 0.17695859, kAgreement);
    EXPECT_NEAR(At(map, 20, 30), 0.81676528, kAgreement) << "the firefly";
    EXPECT_NEAR(At(map, 24, 30), 0.24837242, kAgreement);
    EXPECT_NEAR(At(map, 63, 47), 0.16273366, kAgreement);
}

TEST(Flip, HdrDoesNotDependOnTheUnitOfLight) {
    Images patterns = BrightPatterns();
    const FlipExposures exposures = HdrFlipExposures(patterns.reference);
    const Image map = HdrFlip(patterns.image, patterns.reference, exposures);
    for (Image* image : {&patterns.image, &patterns.reference})
        for (float& v : image->Pixels()) v *= 16;
    const FlipExposures brighter = HdrFlipExposures(patterns.reference);
    EXPECT_NEAR(double(brighter.start), double(exposures.start) - 4, 1e-5);
    // The curve is steep: an exposure wrong by the last place of a float moves its values by some 1e-6.
    EXPECT_NEAR(Mean(HdrFlip(patterns.image, patterns.reference, brighter)), Mean(map), kAgreement);
}

TEST(Flip, LdrIsSymmetricAndWithinZeroAndOne) {
    const Images patterns = BrightPatterns();
    const Image map = LdrFlip(patterns.image, patterns.reference);
    EXPECT_EQ(map.Pixels(), LdrFlip(patterns.reference, patterns.image).Pixels());
    for (const float v : map.Pixels()) ASSERT_TRUE(v >= 0 && v <= 1) << v;
}

TEST(Flip, BlackReferencesHaveExposures) {
    EXPECT_EQ(HdrFlipExposures(Uniform(RGB(0))).count, 1);
    Image mostlyBlack = Uniform(RGB(0));
    mostlyBlack.Set({3, 3}, 1, 50);
    const FlipExposures exposures = HdrFlipExposures(mostlyBlack);
    EXPECT_TRUE(std::isfinite(exposures.stop));
    EXPECT_LT(exposures.count, 64);
    const Image map = HdrFlip(Uniform(RGB(0)), mostlyBlack, exposures);
    EXPECT_FALSE(map.HasNonFinite());
    EXPECT_GT(At(map, 3, 3), 0.5);
}

TEST(Flip, ColourSpaceOfTheImageIsTakenIntoAccount) {
    Images patterns = Patterns();
    const Image map = LdrFlip(patterns.image, patterns.reference);
    const ColorSpace* wide = ColorSpace::Find("rec2020");
    const glm::mat3 toWide = wide->RGBFromXYZ() * ColorSpace::SRGB().XYZFromRGB();
    for (Image* image : {&patterns.image, &patterns.reference}) {
        image->SetColorSpace(wide);
        for (size_t i = 0; i < image->Pixels().size(); i += 3) {
            float* p = image->Pixels().data() + i;
            const RGB rgb = toWide * RGB(p[0], p[1], p[2]);
            for (int c = 0; c < 3; ++c) p[c] = rgb[c];
        }
    }
    EXPECT_NEAR(Mean(LdrFlip(patterns.image, patterns.reference)), Mean(map), kAgreement);
}

}  // namespace
}  // namespace lacquer::compare::flip_test
