// The model for eight texels in single precision against the one with dual numbers.
#include "capture/svbrdf/texel_gradient.h"

#include <gtest/gtest.h>

#include "capture/svbrdf/dual.h"
#include "capture/svbrdf/made_maps.h"

namespace lacquer::capture::texel_gradient_test {
namespace {

using Nonuple = Dual<kNumChannels>;

/// Sum of squares over some photographs, and its derivatives.
struct Squares {
    double value;
    std::array<double, kNumChannels> by;
    std::array<double, 3> byLogPower;
};

constexpr double kY = 1.3;
double XOf(size_t lane) { return -2 + 0.5 * double(lane); }
/// What the photographs show: something between black and white.
double SeenOf(size_t lane, size_t c) { return 0.15 + 0.08 * double(lane) + 0.04 * double(c); }
constexpr std::array<double, 3> kPower{1500, 1400, 900};

Squares ByDuals(const StoredTexel<double>& stored, size_t lane, const std::vector<View>& views) {
    StoredTexel<Nonuple> t;
    for (size_t c = 0; c < kNumChannels; ++c) t[c] = Nonuple::Unknown(stored[c], c);
    Nonuple sum;
    Squares result{};
    for (const View& view : views) {
        const TexelGeometry g = GeometryAt(XOf(lane), kY, view.camera, view.light);
        const auto linear = LinearValue(Decode(t), g, kPower);
        for (size_t c = 0; c < 3; ++c) {
            const Nonuple encoded = EncodedOf(linear[c]), difference = encoded - SeenOf(lane, c);
            sum = sum + difference * difference;
            const double x = linear[c].value, inside = ClampTo(x, kModelEpsilon, 1);
            const double slope = 2 * difference.value * encoded.value / (kModelGamma * inside);
            result.byLogPower[c] += slope * x;
            // All values that are clamped are called back, and go on as if their end had the inside's slope.
            if (x == inside) continue;
            for (size_t i = 0; i < kNumChannels; ++i) sum.by[i] += slope * linear[c].by[i];
        }
    }
    result.value = sum.value;
    result.by = sum.by;
    return result;
}

std::array<Squares, kNumLanes> ByLanes(const StoredLanes& stored, const std::vector<View>& views) {
    Lanes x;
    for (int i = 0; i < kNumLanes; ++i) x[i] = float(XOf(size_t(i)));
    const DecodedLanes decoded = DecodeLanes(stored);
    SumsLanes sums;
    for (const View& view : views) {
        ColorLanes seen;
        for (size_t c = 0; c < 3; ++c)
            for (int i = 0; i < kNumLanes; ++i) seen[c][i] = float(SeenOf(size_t(i), c));
        AddPhotograph(decoded.texel, GeometryOfLanes(x, float(kY), view.camera, view.light),
                      {float(kPower[0]), float(kPower[1]), float(kPower[2])}, seen, AllLanes(1), &sums);
    }
    const StoredLanes by = ByStored(decoded, sums.byTexel);
    std::array<Squares, kNumLanes> result;
    for (int i = 0; i < kNumLanes; ++i) {
        Squares& squares = result[size_t(i)];
        squares.value = double(sums.squares[i]);
        for (size_t c = 0; c < kNumChannels; ++c) squares.by[c] = double(by[c][i]);
        for (size_t c = 0; c < 3; ++c) squares.byLogPower[c] = double(sums.byPower[c][i]);
    }
    return result;
}

/// Compares blocks of eight texels. Derivatives are sums of terms that may cancel: errors are measured on the
/// longest one of the texel, and rounding is 1e-7 times the 100 or so operations.
void Compare(const Maps& maps, const std::vector<View>& views) {
    for (size_t first = 0; first + kNumLanes <= maps.NumTexels(); first += kNumLanes) {
        StoredLanes lanes;
        for (size_t c = 0; c < kNumChannels; ++c)
            for (int i = 0; i < kNumLanes; ++i) lanes[c][i] = float(maps.Channel(c)[first + size_t(i)]);
        const auto byLanes = ByLanes(lanes, views);
        for (size_t i = 0; i < kNumLanes; ++i) {
            StoredTexel<double> stored;
            for (size_t c = 0; c < kNumChannels; ++c) stored[c] = double(lanes[c][int(i)]);
            const Squares expected = ByDuals(stored, i, views);
            EXPECT_NEAR(byLanes[i].value, expected.value, 2e-5 * (expected.value + 0.01));
            double longest = 0;
            for (const double by : expected.by) longest = std::max(longest, std::abs(by));
            for (size_t c = 0; c < kNumChannels; ++c)
                EXPECT_NEAR(byLanes[i].by[c], expected.by[c], 1e-4 * longest + 1e-6) << first + i << ' ' << c;
            for (size_t c = 0; c < 3; ++c)
                EXPECT_NEAR(byLanes[i].byLogPower[c], expected.byLogPower[c],
                            1e-4 * std::abs(expected.byLogPower[c]) + 1e-5);
        }
    }
}

TEST(TexelGradient, IsThatOfTheModelAtTheCamera) {
    Compare(test::RandomMaps(16, 2), test::GridViews(9).views);
}
TEST(TexelGradient, IsThatOfTheModelWithTheLightAside) {
    Compare(test::RandomMaps(16, 3), test::NovelViews());
}
TEST(TexelGradient, IsThatOfTheModelForSmoothMaps) {
    Compare(test::MadeMaps(16, test::Pattern::Waves, 2), test::GridViews(5).views);
}

// Narrow lobes that the light meets nearly in the middle: 1 - cos^2 has few digits there.
TEST(TexelGradient, HoldsForNarrowLobes) {
    Maps maps = test::RandomMaps(8, 4);
    for (double& value : maps.Channel(kRoughness)) value = -0.3 + 0.1 * value;
    for (size_t c = 0; c < 2; ++c)
        for (double& value : maps.Channel(kNormal + c)) value *= 0.1;
    Compare(maps, test::GridViews(9).views);
}

TEST(TexelGradient, PowersOfLanesAreAccurate) {
    for (const double power : {1.2, 1 / 2.2 - 1})
        for (double x = 1e-6; x <= 1; x *= 1.07) {
            const double expected = std::pow(double(float(x)), power);
            EXPECT_NEAR(double(PowLanes(AllLanes(float(x)), float(power))[3]), expected, 4e-6 * expected);
        }
    EXPECT_LT(PowLanes(AllLanes(0), 1.2F)[0], 1e-37F);
}

}  // namespace
}  // namespace lacquer::capture::texel_gradient_test
