// Each function against the C library's in double precision, over its whole domain.
#include "pbrt/core/special_functions.h"

#include <gtest/gtest.h>

namespace lacquer::special_functions_test {
namespace {

/// The largest relative error of `fast` over arguments from `low` to `high` in equal quotients.
template <class Fast, class Exact>
double WorstError(float low, float high, const Fast& fast, const Exact& exact) {
    constexpr int kSteps = 400000;
    double worst = 0;
    for (int i = 0; i <= kSteps; ++i) {
        const auto x = float(double(low) * std::pow(double(high) / double(low), double(i) / kSteps));
        const double error = std::abs(double(fast(x)) / exact(double(x)) - 1);
        worst = error <= worst ? worst : error;  // NaN stays
    }
    return worst;
}

TEST(SpecialFunctions, PolynomialIsTheSumOfItsTerms) {
    constexpr std::array kOdd = {1.f, -2.f, 3.f, -4.f, 5.f};
    EXPECT_EQ(Polynomial(2.f, kOdd), 1 - 4 + 12 - 32 + 80);
    EXPECT_EQ(Polynomial(2.f, std::array{7.f}), 7);
    EXPECT_EQ(Polynomial(3.f, std::array{7.f, -1.f, 1.f, 2.f}), 7 - 3 + 9 + 54);
}

TEST(SpecialFunctions, LogIsAsExactAsItSays) {
    const auto exact = [](double x) { return std::log(x); };
    EXPECT_LT(WorstError(std::numeric_limits<float>::min(), 0.9999f, Log, exact), 2e-7);
    EXPECT_LT(WorstError(1.0001f, std::numeric_limits<float>::max(), Log, exact), 2e-7);
    // Next to 1 every number counts, since samplers have logarithms of 1 - u.
    for (int i = 1; i < 100000; ++i)
        for (const float x : {1 - float(i) * 0x1p-24f, 1 + float(i) * 0x1p-23f})
            ASSERT_NEAR(double(Log(x)) / std::log(double(x)), 1, 2e-7) << x;
    EXPECT_EQ(Log(1), 0);
    EXPECT_LT(Log(0), -80);
    EXPECT_GT(Log(0), -100);
    // Control: the C library's errors are found to be smaller, those of a wrong last coefficient would be
    // found.
    EXPECT_LT(WorstError(
                  0.5f, 0.9999f, [](float x) { return std::log(x); }, exact),
              1e-7);
    EXPECT_GT(WorstError(
                  0.5f, 0.9999f, [](float x) { return Log(x) + 3e-7f * x; }, exact),
              2e-7);
}

TEST(SpecialFunctions, SinCosOfTurnIsAsExactAsItSays) {
    double worst = 0;
    for (int i = -300000; i <= 300000; ++i) {
        const float u = float(i) * 1e-5f;
        const auto [sine, cosine] = SinCosOfTurn(u);
        const double phi = 2 * M_PI * double(u);
        worst = std::max(
            {worst, std::abs(double(sine) - std::sin(phi)), std::abs(double(cosine) - std::cos(phi))});
    }
    EXPECT_LT(worst, 1.3e-7);
    // Small angles keep their digits.
    EXPECT_LT(WorstError(
                  1e-30f, 0.1f, [](float u) { return SinCosOfTurn(u).sin; },
                  [](double u) { return std::sin(2 * M_PI * u); }),
              2e-7);
    EXPECT_EQ(SinCosOfTurn(0).sin, 0);
    EXPECT_LE(std::abs(SinCosOfTurn(OneMinusEpsilon).sin), 4e-7f);
}

TEST(SpecialFunctions, ScaledErfcIsAsExactAsItSays) {
    const auto exact = [](double x) { return std::exp(x * x) * std::erfc(x); };
    EXPECT_LT(WorstError(1e-30f, 4.f, ScaledErfc, exact), 4e-7);
    EXPECT_LT(WorstError(4.f, 25.f, ScaledErfc, exact), 2e-3);
    EXPECT_NEAR(double(ScaledErfc(1e10f)) * 1e10 * std::sqrt(M_PI), 1, 2e-3);
    EXPECT_EQ(ScaledErfc(Infinity), 0);
}

TEST(SpecialFunctions, ErfIsAsExactAsItSays) {
    const auto exact = [](double x) { return std::erf(x); };
    EXPECT_LT(WorstError(std::numeric_limits<float>::min(), 1e30f, Erf, exact), 2.5e-7);
    for (const float x : {0.f, 1e-40f, 1e-10f, 0.3f, 1.f, 1.5f, 7.f, Infinity}) EXPECT_EQ(Erf(-x), -Erf(x));
    EXPECT_EQ(Erf(0), 0);
    EXPECT_EQ(Erf(Infinity), 1);
    EXPECT_LE(Erf(3.9f), 1);
    // Where the two series meet nothing jumps.
    EXPECT_NEAR(double(Erf(1) - Erf(1 - MachineEpsilon)), 0, 2e-7);
}

TEST(SpecialFunctions, ErfInvIsAsExactAsItSays) {
    // The error function in double is the judge: a step of Newton's method from the result, whose own error
    // is of second order. Near 1 the argument's complement keeps the digits.
    const auto relativeError = [](float x) {
        const double y = double(ErfInv(x)), gauss = 2 / std::sqrt(M_PI) * std::exp(-y * y);
        const double excess = x > 0.5f ? (1 - double(x)) - std::erfc(y) : std::erf(y) - double(x);
        return std::abs(excess / gauss / y);
    };
    double worst = 0;
    for (int i = 1; i < (1 << 24); i += 61) worst = std::max(worst, relativeError(float(i) * 0x1p-24f));
    for (float x = 0.1f; x > 1e-37f; x *= 0.87f) worst = std::max(worst, relativeError(x));
    EXPECT_LT(worst, 5e-7);
    EXPECT_EQ(ErfInv(0), 0);
    for (const float x : {1e-20f, 0.5f, 0.999f, OneMinusEpsilon}) EXPECT_EQ(ErfInv(-x), -ErfInv(x));
}

TEST(SpecialFunctions, ErfInvInvertsErf) {
    for (int i = -2500; i <= 2500; ++i) {
        const float x = float(i) * 1e-3f;
        // Rounding of Erf() is amplified by 1/erf'.
        const double tolerance =
            5e-7 * std::abs(double(x)) + 3e-7 * std::abs(double(Erf(x))) * std::exp(double(x) * double(x));
        ASSERT_NEAR(double(ErfInv(Erf(x))), double(x), tolerance) << x;
    }
}

}  // namespace
}  // namespace lacquer::special_functions_test
