// SSIM against its formula, window by window, and against closed forms.
#include "compare/ssim.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lacquer::compare::ssim_test {
namespace {

/// Waves in three channels that differ. @param shift  of the waves [pixels]
Image Waves(int width, int height, double shift, double contrast = 1, double offset = 0) {
    Image image({width, height}, {"R", "G", "B"});
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < 3; ++c) {
                const double wave = std::sin(0.4 * (x + shift) + (0.1 + 0.3 * c) * y);
                image.Pixels()[size_t(3 * (y * width + x) + c)] =
                    float(0.5 + offset + contrast * (0.2 + 0.1 * c) * wave);
            }
    return image;
}

/// The definition, with a window of two dimensions.
double ByDefinition(const Image& a, const Image& b, int channel) {
    const int width = a.Resolution().x, height = a.Resolution().y;
    const auto at = [&](const Image& image, int x, int y) {
        return double(image.Pixels()[size_t(3 * (y * width + x) + channel)]);
    };
    double all = 0, count = 0;
    for (int y = 5; y + 5 < height; ++y)
        for (int x = 5; x + 5 < width; ++x) {
            double sum = 0, ma = 0, mb = 0, va = 0, vb = 0, vab = 0;
            for (int pass = 0; pass < 2; ++pass)
                for (int dy = -5; dy <= 5; ++dy)
                    for (int dx = -5; dx <= 5; ++dx) {
                        const double w = std::exp(-(dx * dx + dy * dy) / 4.5);
                        const double p = at(a, x + dx, y + dy), q = at(b, x + dx, y + dy);
                        if (pass == 0) {
                            sum += w;
                            ma += w * p;
                            mb += w * q;
                        } else {
                            va += w / sum * (p - ma) * (p - ma);
                            vb += w / sum * (q - mb) * (q - mb);
                            vab += w / sum * (p - ma) * (q - mb);
                        }
                        if (pass == 0 && dx == 5 && dy == 5) {
                            ma /= sum;
                            mb /= sum;
                        }
                    }
            all += (2 * ma * mb + 1e-4) * (2 * vab + 9e-4) / ((ma * ma + mb * mb + 1e-4) * (va + vb + 9e-4));
            ++count;
        }
    return all / count;
}

TEST(Ssim, IsItsDefinition) {
    const Image a = Waves(23, 17, 0), b = Waves(23, 17, 1.3, 0.7, 0.05);
    double mean = 0;
    for (int c = 0; c < 3; ++c) mean += ByDefinition(a, b, c) / 3;
    EXPECT_NEAR(Ssim(a, b, {"R", "G", "B"}), mean, 1e-9);
    EXPECT_NEAR(Ssim(a, b, {"G"}), ByDefinition(a, b, 1), 1e-9);
    // The control: channels differ, so that one for another would be seen.
    EXPECT_GT(std::abs(ByDefinition(a, b, 0) - ByDefinition(a, b, 2)), 0.01);
}

TEST(Ssim, OfTheSameImageIsOneAndFallsWithWhatDiffers) {
    const Image a = Waves(32, 32, 0);
    EXPECT_NEAR(Ssim(a, a, {"R", "G", "B"}), 1, 1e-12);
    double last = 1;
    for (const double shift : {0.5, 1., 2., 4.}) {
        const double ssim = Ssim(a, Waves(32, 32, shift), {"R", "G", "B"});
        EXPECT_LT(ssim, last);
        EXPECT_NEAR(Ssim(Waves(32, 32, shift), a, {"R", "G", "B"}), ssim, 1e-12);
        last = ssim;
    }
}

// Flat images differ by their means alone, eq. 6 of the paper.
TEST(Ssim, OfFlatImagesComparesMeans) {
    Image a({11, 11}, {"Y"}), b = a;
    for (float& v : a.Pixels()) v = 0.2F;
    for (float& v : b.Pixels()) v = 0.6F;
    EXPECT_NEAR(Ssim(a, b, {"Y"}), (2 * 0.2 * 0.6 + 1e-4) / (0.04 + 0.36 + 1e-4), 1e-6);
}

}  // namespace
}  // namespace lacquer::compare::ssim_test
