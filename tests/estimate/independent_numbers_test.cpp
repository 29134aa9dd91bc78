// Photograph and summaries against numbers of another implementation: the definitions, written in NumPy 1.24
// with its own transforms, of images and surfaces with closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "estimate/photo/tone.h"
#include "estimate/summary/summary.h"

namespace lacquer::estimate::independent_numbers_test {
namespace {

constexpr int kSize = 64;
const MapGrid kGrid{kSize, 16, true};

/// Waves of several frequencies and directions, with phases of the channels that differ.
PlanarImage WaveImage() {
    PlanarImage image(kSize);
    for (int k = 0; k < 3; ++k)
        for (int i = 0; i < kSize; ++i)
            for (int j = 0; j < kSize; ++j)
                image.Channel(size_t(k))[size_t(i * kSize + j)] =
                    0.5 + 0.15 * std::sin(0.7 * i + 0.31 * j + k) +
                    0.12 * std::sin(0.05 * i * j / 8 + 0.2 * k) +
                    0.1 * std::cos(2.1 * i - 1.3 * j) * std::sin(0.11 * i);
    return image;
}

std::vector<double> ValuesOf(const std::string& family) {
    SummarySet set({family}, kGrid);
    std::vector<double> values(set.Size());
    set.Forward(WaveImage(), values);
    return values;
}

void ExpectNear(std::span<const double> values, std::span<const double> expected, double tolerance) {
    for (size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(values[i], expected[i], tolerance) << i;
}

TEST(IndependentNumbers, Spectrum) {
    const double expected[] = {-2.0916, -2.0923, -1.0344, -1.3816, -1.5669, -1.6935, -3.5142, -2.2738,
                               -6.6443, -1.4827, -7.7185, -7.2063, -7.7611, -7.5240, -7.7641, -3.2210};
    ExpectNear(ValuesOf("spectrum"), expected, 1e-4);
}

TEST(IndependentNumbers, SpectraOfColumnsAndRows) {
    const double columns[] = {-2.89515, -1.60894, -1.61835, -2.92108, -5.62611, -3.20602, -1.90496, -1.61065,
                              -2.60263, -2.60821, -2.61035, -2.42917, -1.98430, -1.98377, -1.98360, -1.98576,
                              -4.56638, -4.56639, -4.56636, -4.56640, -3.03903, -3.03903, -3.03903, -3.03903};
    const double rows[] = {-2.22041, -1.43619, -1.55462, -2.22223, -1.51912, -1.46708, -1.34630, -1.27934,
                           -5.24299, -5.24373, -5.16636, -3.14288, -6.25354, -6.38881, -6.11439, -6.45734,
                           -2.76379, -2.92729, -2.61192, -3.15657, -7.27359, -7.27374, -7.27341, -7.27385};
    const auto values = ValuesOf("columnspectrum");
    ExpectNear(std::span(values).first(24), columns, 2e-5);
    ExpectNear(std::span(values).last(24), rows, 2e-5);
}

TEST(IndependentNumbers, Rings) {
    const double means[] = {0.578223, 0.473229, 0.484499, 0.514559, 0.461587, 0.455452,
                            0.513815, 0.508279, 0.529278, 0.568666, 0.532595, 0.505243};
    const double detail[] = {-3.364838, -3.222728, -3.123754, -2.97069,  -2.870993, -2.828142,
                             -2.787746, -2.818828, -2.862325, -2.911396, -2.972289};
    const auto values = ValuesOf("rings");
    ExpectNear(std::span(values).first(12), means, 1e-6);
    // The last ring touches the border, which the other implementation takes for periodic.
    ExpectNear(std::span(values).subspan(12), detail, 1e-6);
}

// There every octave has the full resolution. Energies are the same, as sums over the same frequencies;
// kurtosis and correlations are in the first octave, and nearly so where fourth powers reach beyond the
// Nyquist frequency.
TEST(IndependentNumbers, Pyramid) {
    const double energies[] = {-4.582256, -4.469081, -3.687228, -3.390829, -4.212922, -2.245467,
                               -2.293656, -4.313215, -3.105642, -2.649041, -3.081617, -4.100092,
                               -3.377265, -2.976347, -3.391882, -4.596563};
    const double sparsity[] = {2.698889, 2.071784, 0.743498, 0.430101};
    const double coarserSparsity[] = {1.416580, 0.100981, 0.038932, 1.685302};
    const auto values = ValuesOf("pyramid");
    ExpectNear(values, energies, 2e-6);
    ExpectNear(std::span(values).subspan(16), sparsity, 1e-6);
    ExpectNear(std::span(values).subspan(20), coarserSparsity, 0.1);
    EXPECT_NEAR(values[32], 0.6380299813, 1e-8);  // orientations 0 and 1
    EXPECT_NEAR(values[33], 0.3255340111, 1e-8);  // 0 and 2
    EXPECT_NEAR(values[34], 0.3120735529, 1e-8);  // 0 and 3
    EXPECT_NEAR(values[35], 0.5285023219, 0.06);  // octaves 0 and 1
}

/// A relief with one wave along each direction.
Surface Waves() {
    Surface s;
    for (int i = 0; i < kSize; ++i)
        for (int j = 0; j < kSize; ++j) {
            const double x = ((j + 0.5) / kSize - 0.5), y = (i + 0.5) / kSize - 0.5;
            s.height.push_back(0.05 * std::sin(2 * std::numbers::pi * 3 * x) *
                               std::cos(2 * std::numbers::pi * 2 * y));
        }
    SlopesOf(kGrid, s.height, &s.slopeX, &s.slopeY);
    return s;
}

TEST(IndependentNumbers, PhotographsOfADielectricAndOfMetal) {
    Surface s = Waves();
    s.albedo = {Field{0.5}, Field{0.3}, Field{0.1}};
    s.roughness = {0.3};
    const FlashPhoto photo(kGrid, 25, Brdf::Chapter);
    PlanarImage linear, toned;
    const auto at = [&](size_t k, int row, int column) {
        return toned.Channel(k)[size_t(row * kSize + column)];
    };
    const auto mean = [&](size_t k) {
        double sum = 0;
        for (const double v : toned.Channel(k)) sum += v;
        return sum / (kSize * kSize);
    };
    photo.Forward(s, {1000, 8, 0, 0}, &linear);
    ApplyTone(ToneCurve::Gamma22, linear, &toned);
    const double means[] = {0.47417174, 0.38903516, 0.26820466},
                 inside[] = {0.55115173, 0.45893465, 0.33610448};
    const double corner[] = {0.38005118, 0.30225633, 0.18630759};
    for (size_t k = 0; k < 3; ++k) {
        EXPECT_NEAR(mean(k), means[k], 1e-8);
        EXPECT_NEAR(at(k, 20, 40), inside[k], 1e-8);
        EXPECT_NEAR(at(k, 5, 9), corner[k], 1e-8);
    }
    s.reflectance = Reflectance::Metal;
    s.roughnessX = 0.1;
    s.roughnessY = 0.4;
    for (Field& f0 : s.albedo) f0 = {0.4};
    photo.Forward(s, {1000, 8, 0, 0}, &linear);
    ApplyTone(ToneCurve::Gamma22, linear, &toned);
    EXPECT_NEAR(at(0, 20, 40), 0.21893863, 1e-8);
    EXPECT_NEAR(at(1, 30, 33), 0.54306547, 1e-8);
    // There values below 10^-6 are raised to it: none of a mean of 0.1 that is seen here at 10^-4.
    EXPECT_NEAR(mean(0), 0.11790717, 2e-3);
}

}  // namespace
}  // namespace lacquer::estimate::independent_numbers_test
