// The exponential of inner loops.
#include "pbrt/core/math.h"

#include <gtest/gtest.h>

#include "pbrt/core/sampled_spectrum.h"
#include "support/lanes.h"

namespace lacquer::math_test {
namespace {

using test::Lanes;

TEST(Exp, IsAsExactAsItSays) {
    for (double x = -87; x <= 88; x += 0.00137) {
        const float rounded = float(x);
        ASSERT_NEAR(double(Exp(rounded)) / std::exp(double(rounded)), 1, 1.5e-7) << x;
    }
    EXPECT_EQ(Exp(0.f), 1);
}

TEST(Exp, EndsQuietly) {
    EXPECT_EQ(Exp(-87.5f), 0);
    EXPECT_EQ(Exp(-Infinity), 0);
    EXPECT_GT(Exp(-87.f), 0);
    EXPECT_LT(Exp(Infinity), Infinity);
}

TEST(Exp, IsTheSameForSpectra) {
    const auto isSame = [](SampledSpectrum x) {
        for (int i = 0; i < kNumWavelengths; ++i) {
            const float one = Exp(x[i]);
            // To rounding: whether products and sums are fused is up to the compiler, for Exp(float) it is
            // said.
            EXPECT_NEAR(Exp(x)[i], one, 3e-7f * one) << x[i];
        }
    };
    isSame(Lanes(-0.3f, -1, -20, 0));
    isSame(Lanes(-87, -87.5f, -Infinity, Infinity));
    isSame(Lanes(88, 88.5f, -1e30f, 1e30f));
    for (float x = -87; x < 87; x += 0.0173f) isSame(Lanes(x, -x, x / 3, x + 1));
    EXPECT_TRUE(std::isnan(Exp(SampledSpectrum(std::numeric_limits<float>::quiet_NaN()))[0]));
}

TEST(ATan2, IsAsExactAsItSays) {
    const auto relativeError = [](float y, float x) {
        const double exact = std::atan2(double(y), double(x));
        return std::abs(double(ATan2(y, x)) / exact - 1);
    };
    for (int i = 1; i < 200000; ++i) {
        const double phi = -3.14159265 + 6.2831853 * i / 200000;
        for (const double length : {1e-30, 0.37, 1e30}) {
            const float y = float(length * std::sin(phi)), x = float(length * std::cos(phi));
            if (y != 0) {
                ASSERT_LT(relativeError(y, x), 3e-7) << phi;
            }
        }
    }
    EXPECT_LT(relativeError(1e-20f, 1), 3e-7);
    EXPECT_LT(relativeError(1, 1e-20f), 3e-7);
}

TEST(ATan2, KnowsTheAxes) {
    EXPECT_EQ(ATan2(0, 0), 0);
    EXPECT_EQ(ATan2(0, 1), 0);
    EXPECT_EQ(ATan2(1, 0), PiOver2);
    EXPECT_EQ(ATan2(-1, 0), -PiOver2);
    EXPECT_EQ(ATan2(0, -1), Pi);
    EXPECT_EQ(ATan2(-0.f, -1), -Pi);
}

}  // namespace
}  // namespace lacquer::math_test
