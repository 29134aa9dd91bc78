// The exponential of inner loops.
#include "pbrt/core/math.h"

#include <gtest/gtest.h>

#include "pbrt/core/sampled_spectrum.h"

namespace lacquer {
namespace {

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
    const SampledSpectrum x(SampledSpectrum::Lanes{-0.3f, -1, -20, 0});
    for (int i = 0; i < kNumWavelengths; ++i) EXPECT_EQ(Exp(x)[i], Exp(x[i]));
}

}  // namespace
}  // namespace lacquer
