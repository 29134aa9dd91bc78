// Tone maps against their closed forms.
#include "compare/tone_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace lacquer::compare::tone_map_test {
namespace {

TEST(ToneMap, NoneAndClampAreWhatTheySay) {
    EXPECT_EQ(Apply(ToneMap::None, {-1, 0.5f, 7}, 3), RGB(-1, 0.5f, 7));
    EXPECT_EQ(Apply(ToneMap::Clamp, {-1, 0.5f, 7}, 3), RGB(0, 0.5f, 1));
}

TEST(ToneMap, ReinhardBringsLuminanceToItsQuotient) {
    // Grey of luminance L becomes L / (1 + L); hue stays where nothing is cut off.
    for (const float L : {0.f, 0.18f, 1.f, 100.f})
        EXPECT_FLOAT_EQ(Apply(ToneMap::Reinhard, RGB(L), L).x, L / (1 + L));
    const RGB mapped = Apply(ToneMap::Reinhard, {0.2f, 0.4f, 0.6f}, 1);
    EXPECT_FLOAT_EQ(mapped.y / mapped.x, 2);
    EXPECT_FLOAT_EQ(mapped.z / mapped.x, 3);
}

TEST(ToneMap, AcesRisesFromBlackToWhiteAndInverts) {
    EXPECT_EQ(AcesCurve::Evaluate(0), 0);
    EXPECT_EQ(AcesCurve::Evaluate(1e30f), 1);
    float previous = -1;
    for (float x = 1e-4f; x < 20; x *= 1.5f) {
        const float y = AcesCurve::Evaluate(x);
        EXPECT_GE(y, previous);
        previous = y;
        // The slope of the curve is at least y / x / 4 below 0.9, so rounding of y costs some 4 ulps of x.
        if (y >= 0.9f) continue;
        EXPECT_NEAR(AcesCurve::Inverse(double(y)), double(x), 2e-6 * double(x)) << x;
    }
}

TEST(ToneMap, OddValuesStayInRange) {
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    for (const ToneMap map : {ToneMap::Clamp, ToneMap::Reinhard, ToneMap::Aces}) {
        const RGB mapped = Apply(map, {inf, -inf, -3}, inf);
        EXPECT_EQ(mapped, RGB(1, 0, 0));
        EXPECT_TRUE(std::isnan(Apply(map, RGB(nan), nan).x));
    }
}

TEST(ToneMap, NamesAreParsedBack) {
    for (const std::string& name : ToneMapNames()) EXPECT_TRUE(ParseToneMap(name)) << name;
    EXPECT_FALSE(ParseToneMap("acess"));
}

}  // namespace
}  // namespace lacquer::compare::tone_map_test
