#include "pbrt/core/lane_functions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace lacquer::lane_functions_test {
namespace {

/// Neighbours at once, so that lanes are not mixed up.
LaneFloats From(float first, float step) {
    return MakeLanes<LaneFloats>([=](int i) { return first + float(i) * step; });
}

template <class Function>
double WorstExp(const Function& function) {
    double worst = 0;
    for (float x = -86.9f; x < 86; x += 0.004f) {
        const LaneFloats at = From(x, 0.0005f), y = function(at);
        for (int i = 0; i < kNumWavelengths; ++i)
            worst = std::max(worst, std::abs(double(y[i]) / std::exp(double(at[i])) - 1));
    }
    return worst;
}

TEST(LaneFunctions, ExpIsAsExactAsItSays) {
    EXPECT_LT(WorstExp(ExpOfLanes), 2e-7);
    EXPECT_GT(WorstExp([](LaneFloats x) { return ExpOfLanes(x) * (1 + 3e-7f); }), 2e-7);  // it would be seen
    EXPECT_EQ(ExpOfLanes(LaneFloats{})[0], 1);
    for (const float low : {-87.5f, -1e4f, -1e30f, -Infinity})
        EXPECT_NEAR(ExpOfLanes(LaneFloats{0, low, 0, 0})[1], 0, 3e-38f);
}

template <class Function>
double WorstLog(const Function& function) {
    double worst = 0;
    const auto look = [&](LaneFloats x) {
        const LaneFloats y = function(x);
        for (int i = 0; i < kNumWavelengths; ++i)
            worst = std::max(worst, std::abs(double(y[i]) / std::log(double(x[i])) - 1));
    };
    for (int exponent = -126; exponent < 127; ++exponent)
        for (float m = 1; m < 2; m += 0.01f) look(std::ldexp(1.f, exponent) * From(m, 0.00125f));
    // Next to 1, where the logarithm is as small as what x differs.
    for (float difference = 1e-6f; difference < 0.5f; difference *= 1.1f) {
        look(From(1 + difference, 1e-7f));
        look(From(1 - difference, -1e-7f));
    }
    return worst;
}

TEST(LaneFunctions, LogIsAsExactAsItSays) {
    EXPECT_LT(WorstLog(LogOfLanes), 3e-7);
    EXPECT_GT(WorstLog([](LaneFloats x) { return LogOfLanes(x) * (1 + 4e-7f); }), 3e-7);
    EXPECT_EQ(LogOfLanes(LaneFloats{} + 1.f)[0], 0);
}

/// Error of the pair that `function` gives for n + r quarters.
template <class Function>
double WorstSinCos(const Function& function) {
    double worst = 0;
    for (const int first : {-4000000, -6, 0, 1, 4194000})
        for (int step = -5000; step <= 5000; ++step) {
            const auto n = MakeLanes<LaneInts>([first](int i) { return first + i; });
            const LaneFloats r = LaneFloats{} + float(step) * 1e-4f;
            const LaneSinCos y = function(n, r);
            for (int i = 0; i < kNumWavelengths; ++i) {
                // Whole turns are left out where they are exact.
                const double phi = std::numbers::pi / 2 * (double(n[i] & 3) + double(r[i]));
                worst = std::max({worst, std::abs(double(y.sin[i]) - std::sin(phi)),
                                  std::abs(double(y.cos[i]) - std::cos(phi))});
            }
        }
    return worst;
}

TEST(LaneFunctions, SinCosIsAsExactAsItSays) {
    EXPECT_LT(WorstSinCos(SinCosOfQuarters), 2e-7);
    EXPECT_GT(WorstSinCos([](LaneInts n, LaneFloats r) { return SinCosOfQuarters(n, r + 3e-7f); }), 2e-7);
    EXPECT_GT(WorstSinCos([](LaneInts n, LaneFloats r) { return SinCosOfQuarters(n + 1, r); }), 0.5);
    const LaneSinCos none = SinCosOfQuarters(LaneInts{}, LaneFloats{});
    EXPECT_EQ(none.sin[0], 0);
    EXPECT_NEAR(none.cos[0], 1, 1e-7f);
}

}  // namespace
}  // namespace lacquer::lane_functions_test
