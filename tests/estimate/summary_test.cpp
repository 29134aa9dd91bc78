#include "estimate/summary/summary.h"

#include <gtest/gtest.h>

#include <numbers>

#include "estimate/gradient_check.h"

namespace lacquer::estimate::summary_test {
namespace {

const MapGrid kGrid{64, 16, false};

/// An image with detail at all frequencies.
PlanarImage NoisyImage(uint64_t seed) {
    PlanarImage image(kGrid.size);
    image.values = RandomNumbers(image.values.size(), seed, 0.1, 0.9);
    return image;
}

std::vector<double> ValuesOf(SummarySet* set, const PlanarImage& image) {
    std::vector<double> values(set->Size());
    set->Forward(image, values);
    return values;
}

/// Error of the gradient of sum of w_k S_k, by GradientError, after it was multiplied by `factor`.
double ErrorOf(const std::string& family, double factor, double step) {
    SummarySet set({family}, kGrid);
    const PlanarImage image = NoisyImage(3);
    const auto weights = RandomNumbers(set.Size(), 8, -1, 1);
    ValuesOf(&set, image);
    std::vector<double> gradient = set.Backward(weights).values;
    for (double& g : gradient) g *= factor;
    const auto f = [&](std::span<const double> x) {
        PlanarImage moved(kGrid.size);
        moved.values.assign(x.begin(), x.end());
        return Dot(ValuesOf(&set, moved), weights);
    };
    return GradientError(f, image.values, gradient, step, 4);
}

class SummaryFamily : public testing::TestWithParam<std::string_view> {};

// Steps of 1e-4 of values of size one: truncation of order 1e-12, rounding of 1e-16 n / step. Filters that
// cut answers off at 0 and sorted values have kinks, of which a step of 1e-4 would meet some among 10^4
// answers: their steps are smaller, and rounding is what is left.
TEST_P(SummaryFamily, GradientIsThatOfDifferences) {
    const std::string family(GetParam());
    const bool hasKinks = family == "gram" || family == "histogram";
    const double step = hasKinks ? 1e-7 : 1e-4;
    EXPECT_LT(ErrorOf(family, 1, step), hasKinks ? 1e-6 : 1e-7);
    // The control: an error of a part in ten thousand is seen.
    EXPECT_GT(ErrorOf(family, 1.0001, step), 2e-5);
}

TEST_P(SummaryFamily, HasOneNameForEachFiniteNumber) {
    SummarySet set({std::string(GetParam())}, kGrid);
    auto names = set.Names();
    PlanarImage black(kGrid.size), noisy = NoisyImage(1);
    for (const double v : ValuesOf(&set, black)) EXPECT_TRUE(std::isfinite(v));
    for (const double v : ValuesOf(&set, noisy)) EXPECT_TRUE(std::isfinite(v));
    std::sort(names.begin(), names.end());
    EXPECT_EQ(std::unique(names.begin(), names.end()), names.end());
}

// The way back may be gone twice.
TEST_P(SummaryFamily, BackwardLeavesNothingBehind) {
    SummarySet set({std::string(GetParam())}, kGrid);
    ValuesOf(&set, NoisyImage(2));
    const auto weights = RandomNumbers(set.Size(), 8, -1, 1);
    const auto once = set.Backward(weights).values;
    EXPECT_EQ(once, set.Backward(weights).values);
}

INSTANTIATE_TEST_SUITE_P(All, SummaryFamily, testing::ValuesIn(SummaryFamilies()),
                         [](const auto& family) { return std::string(family.param); });

TEST(Summary, UnknownFamilyIsNamed) {
    try {
        SummarySet({"ring"}, kGrid);
        FAIL();
    } catch (const std::invalid_argument& e) {
        EXPECT_STREQ(e.what(), "there are no summaries \"ring\"; did you mean \"rings\"?");
    }
}

TEST(Summary, ColourHasMeansAndCovariances) {
    SummarySet set({"colour"}, kGrid);
    PlanarImage image(kGrid.size);
    for (size_t i = 0; i < image.NumPixels(); ++i) {
        const double sign = (i + i / 64) % 2 == 0 ? 1 : -1;
        image.Channel(0)[i] = 0.5 + 0.1 * sign;
        image.Channel(1)[i] = 0.3 - 0.2 * sign;
        image.Channel(2)[i] = 0.2;
    }
    const auto values = ValuesOf(&set, image);
    const double expected[] = {0.5, 0.3, 0.2, 0.01, -0.02, 0, 0.04, 0, 0};
    for (size_t k = 0; k < std::size(expected); ++k) EXPECT_NEAR(values[k], expected[k], 1e-13) << k;
}

// A wave has its energy in the band of its frequency and the sector of its direction.
TEST(Summary, SpectrumFindsAWave) {
    SummarySet set({"spectrum"}, kGrid);
    PlanarImage image(kGrid.size);
    constexpr int kCycles = 12;
    for (size_t k = 0; k < 3; ++k)
        for (size_t i = 0; i < image.NumPixels(); ++i)
            image.Channel(k)[i] = 0.5 + 0.2 * std::cos(2 * std::numbers::pi * kCycles * double(i / 64) / 64);
    const auto values = ValuesOf(&set, image);
    const size_t largest = size_t(std::max_element(values.begin(), values.end()) - values.begin());
    // Bands from 1.5 to 32 cycles in 8 equal ratios: 12 is in the sixth.
    EXPECT_EQ(largest, 5 * 2 + 1);
    EXPECT_EQ(set.Names()[largest].substr(0, 10), "energy at ");
}

// Where an octave is made at a smaller size, its energies are what they are at the full size: sums over the
// same frequencies. White noise has equal energies in equal areas: half a log of 4 between octaves.
TEST(Summary, PyramidOfWhiteNoiseFallsByHalvesOfAreas) {
    const MapGrid grid{256, 16, false};
    SummarySet set({"pyramid"}, grid);
    PlanarImage image(grid.size);
    image.values = RandomNumbers(image.values.size(), 5, 0, 1);
    std::vector<double> values(set.Size());
    set.Forward(image, values);
    for (size_t octave = 0; octave + 1 < 4; ++octave) {
        double step = 0;
        for (size_t o = 0; o < 4; ++o) step += (values[4 * octave + o] - values[4 * octave + 4 + o]) / 4;
        // The coarsest octave has about 400 independent coefficients: 5 % in energy, 0.025 in half its log; 5
        // sigma.
        EXPECT_NEAR(step, std::log(2), 0.125) << octave;
    }
    // Complex Gaussian magnitudes have a kurtosis of E m^4 / (E m^2)^2 = 2.
    for (size_t o = 0; o < 4; ++o) EXPECT_NEAR(values[16 + o], std::log(2), 0.05);
}

}  // namespace
}  // namespace lacquer::estimate::summary_test
