#include "pbrt/core/spectrum.h"

#include <gtest/gtest.h>

#include "pbrt/core/rng.h"
#include "support/lanes.h"
#include "support/statistics.h"

namespace lacquer::spectrum_test {
namespace {

using test::Lanes, test::SeedOf, test::FullTestName;

TEST(WavelengthWarp, InvertUndoesSample) {
    for (int i = 0; i <= 1000; ++i) {
        const float u = float(i) / 1000 * OneMinusEpsilon;
        const float lambda = SampleVisibleWavelength(u);
        EXPECT_GE(lambda, kLambdaMin - 0.01f);
        EXPECT_LE(lambda, kLambdaMax + 0.01f);
        // lambda is rounded to 3e-5 nm and the density is at most 0.004 per nm; the constants have 8 digits.
        EXPECT_NEAR(InvertVisibleWavelength(lambda), u, 1e-6f);
    }
}

TEST(WavelengthWarp, PdfIsTheSlopeOfInvert) {
    for (float lambda = 365; lambda < 825; lambda += 7.3f) {
        const double slope =
            (double(InvertVisibleWavelength(lambda + 2)) - double(InvertVisibleWavelength(lambda - 2))) / 4;
        EXPECT_NEAR(double(PdfVisibleWavelength(lambda)), slope, 2e-3 * slope + 1e-6) << lambda;
        const double t = std::cosh(0.0072 * (double(lambda) - 538));
        EXPECT_NEAR(double(PdfVisibleWavelength(lambda)), 0.0039398042 / (t * t), 1e-8);
    }
}

TEST(WavelengthWarp, PdfIntegratesToOneAndIsZeroOutside) {
    double sum = 0;
    for (int i = 0; i < 4700; ++i) sum += 0.1 * double(PdfVisibleWavelength(360.05f + 0.1f * float(i)));
    EXPECT_NEAR(sum, 1, 1e-5);
    EXPECT_EQ(PdfVisibleWavelength(359), 0);
    EXPECT_EQ(PdfVisibleWavelength(831), 0);
}

TEST(SampledWavelengths, RotateOneNumberOverTheLanes) {
    for (const float u : {0.f, 0.1f, 0.6f, 0.99f, OneMinusEpsilon}) {
        const SampledWavelengths visible = SampledWavelengths::SampleVisible(u);
        const SampledWavelengths uniform = SampledWavelengths::SampleUniform(u, 400, 700);
        for (int i = 0; i < kNumWavelengths; ++i) {
            const float v = u + float(i) / kNumWavelengths, rotated = v >= 1 ? v - 1 : v;
            EXPECT_NEAR(visible[i], SampleVisibleWavelength(rotated), 1e-3f);
            EXPECT_NEAR(visible.Pdf()[i], PdfVisibleWavelength(visible[i]), 1e-7f);
            EXPECT_NEAR(uniform[i], Lerp(rotated, 400, 700), 1e-3f);
            EXPECT_NEAR(uniform.Pdf()[i], 1 / 300.f, 1e-8f);
        }
    }
}

TEST(SampledWavelengths, TerminateSecondaryKeepsTheEstimate) {
    SampledWavelengths lambda = SampledWavelengths::SampleVisible(0.4f);
    const float pdf = lambda.Pdf()[0];
    EXPECT_FALSE(lambda.SecondaryTerminated());
    lambda.TerminateSecondary();
    EXPECT_TRUE(lambda.SecondaryTerminated());
    EXPECT_EQ(lambda.Pdf()[0], pdf / kNumWavelengths);
    EXPECT_EQ(lambda.Lambda(), SampledSpectrum(lambda[0]));
    lambda.TerminateSecondary();
    EXPECT_EQ(lambda.Pdf()[0], pdf / kNumWavelengths);
    // The average over all elements of a quantity f is now the one-wavelength estimate f / pdf.
    EXPECT_NEAR(SafeDivide(SampledSpectrum(3), lambda.Pdf()).Average(), 3 / pdf, 1e-4f * 3 / pdf);
}

TEST(SampledSpectrum, ArithmeticIsByElement) {
    const SampledSpectrum a = Lanes(1, 2, 3, 4), b = Lanes(4, 3, 2, 0.5f);
    EXPECT_EQ(a + b, Lanes(5, 5, 5, 4.5f));
    EXPECT_EQ(a - b, Lanes(-3, -1, 1, 3.5f));
    EXPECT_EQ(a * b, Lanes(4, 6, 6, 2));
    EXPECT_EQ(a / b, Lanes(0.25f, 2.f / 3, 1.5f, 8));
    EXPECT_EQ(2 * a, a + a);
    EXPECT_EQ(a / 2, 0.5f * a);
    EXPECT_EQ(1 - a, Lanes(0, -1, -2, -3));
    EXPECT_EQ(-a + a, SampledSpectrum(0));
    EXPECT_EQ(Min(a, b), Lanes(1, 2, 2, 0.5f));
    EXPECT_EQ(Max(a, b), Lanes(4, 3, 3, 4));
    EXPECT_EQ(Clamp(a, 1.5f, 3), Lanes(1.5f, 2, 3, 3));
    EXPECT_EQ(Sqrt(a * a), a);
    EXPECT_EQ(SafeSqrt(-a), SampledSpectrum(0));
    EXPECT_EQ(Lerp(0.25f, a, a), a);
    EXPECT_EQ(a.Sum(), 2.5f * kNumWavelengths);
    EXPECT_EQ(a.Average(), 2.5f);
    EXPECT_EQ(a.MaxComponent(), 4);
    EXPECT_EQ(a.MinComponent(), 1);
    EXPECT_NEAR(Exp(a)[2], std::exp(3.f), 1e-5f);
}

TEST(SampledSpectrum, LooksAtEachElement) {
    for (int lane = 0; lane < kNumWavelengths; ++lane) {
        SampledSpectrum s(2);
        s.Set(lane, 5);
        EXPECT_EQ(s.MaxComponent(), 5);
        EXPECT_EQ((-s).MinComponent(), -5);
        EXPECT_EQ(s.Sum(), 2 * kNumWavelengths + 3);
        EXPECT_FALSE(s == SampledSpectrum(2)) << lane;
        EXPECT_TRUE(bool(s - SampledSpectrum(2))) << lane;
        s.Set(lane, 2);
        EXPECT_TRUE(s == SampledSpectrum(2));
        EXPECT_FALSE(bool(s - SampledSpectrum(2)));
    }
}

TEST(SampledSpectrum, SafeDivideGivesZeroWhereTheDivisorIs) {
    const SampledSpectrum q = SafeDivide(Lanes(1, 0, 6, -1), Lanes(0, 0, 2, -0.0f));
    EXPECT_EQ(q, Lanes(0, 0, 3, 0));
}

TEST(SampledSpectrum, KnowsZeroAndInvalidValues) {
    EXPECT_FALSE(bool(SampledSpectrum(0)));
    EXPECT_TRUE(bool(SampledSpectrum(NAN)));
    EXPECT_TRUE(SampledSpectrum(0).IsValid());
    for (const float bad : {NAN, Infinity, -Infinity, -1e-20f})
        for (int lane = 0; lane < kNumWavelengths; ++lane) {
            SampledSpectrum s(1);
            s.Set(lane, bad);
            EXPECT_FALSE(s.IsValid()) << bad;
        }
}

TEST(Spectrum, ObserverHasItsKnownIntegrals) {
    double sum[3] = {0, 0, 0};
    for (int nm = 360; nm <= 830; ++nm) {
        sum[0] += double(CieX().Evaluate(float(nm)));
        sum[1] += double(CieY().Evaluate(float(nm)));
        sum[2] += double(CieZ().Evaluate(float(nm)));
    }
    EXPECT_NEAR(sum[1], 106.857, 1e-3);
    EXPECT_NEAR(sum[1], double(kCieYIntegral), 2e-4);
    EXPECT_NEAR(double(InnerProduct(CieY(), ConstantSpectrum(2))), 2 * sum[1], 1e-4);
    // The equal-energy spectrum is white by the observer's definition, but for the digits of its table.
    EXPECT_NEAR(sum[0] / sum[1], 1, 5e-4);
    EXPECT_NEAR(sum[2] / sum[1], 1, 5e-4);
    // The luminous efficiency peaks with 1 at 555 nm.
    EXPECT_NEAR(CieY().MaxValue(), 1, 1e-4f);
    EXPECT_NEAR(CieY().Evaluate(555), 1, 1e-4f);
}

TEST(Spectrum, BlackbodyFollowsPlanckWienAndStefanBoltzmann) {
    for (const float kelvin : {1500.f, 3000.f, 6504.f, 20000.f}) {
        // Wien: the maximum lies at b / T and is 1 after normalisation.
        const BlackbodySpectrum spectrum(kelvin);
        const float peak = 2.8977721e6f / kelvin;
        EXPECT_NEAR(spectrum.Evaluate(peak), 1, 1e-5f);
        EXPECT_LT(spectrum.Evaluate(peak * 1.02f), 1);
        EXPECT_LT(spectrum.Evaluate(peak * 0.98f), 1);
        EXPECT_LE(spectrum.Evaluate(550), spectrum.MaxValue() * 1.00001f);
        // Stefan and Boltzmann: pi times the integral is sigma T^4; midpoints in log lambda from 1/50 to 1000
        // times the peak leave out less than 1e-6.
        double sum = 0;
        constexpr int kCells = 4000;
        for (int i = 0; i < kCells; ++i) {
            const double x = std::log(0.02) + (std::log(1000.0) - std::log(0.02)) * (i + 0.5) / kCells;
            const double metres = double(peak) * std::exp(x) * 1e-9;
            sum += double(BlackbodyRadiance(float(metres * 1e9), kelvin)) * metres;
        }
        sum *= (std::log(1000.0) - std::log(0.02)) / kCells;
        const double expected = 5.670373e-8 * std::pow(double(kelvin), 4) / 3.14159265358979;
        EXPECT_NEAR(sum / expected, 1, 1e-4);
    }
    // Wien's approximation where h c / (lambda k T) = 24: the -1 in the denominator is nothing.
    const double exponent = 6.62606957e-34 * 299792458 / (400e-9 * 1.3806488e-23 * 1500);
    const double wien =
        2 * 6.62606957e-34 * 299792458.0 * 299792458.0 / std::pow(400e-9, 5) * std::exp(-exponent);
    EXPECT_NEAR(double(BlackbodyRadiance(400, 1500)) / wien, 1, 1e-6);
    EXPECT_EQ(BlackbodyRadiance(500, 0), 0);
}

TEST(Spectrum, PiecewiseLinearIsZeroOutsideUnlessExtended) {
    const std::vector<float> lambda = {400, 500, 700}, values = {1, 3, 2};
    const PiecewiseLinearSpectrum inlined(lambda, values);
    EXPECT_EQ(inlined.Evaluate(399.9f), 0);
    EXPECT_EQ(inlined.Evaluate(700.1f), 0);
    for (size_t i = 0; i < 3; ++i) EXPECT_EQ(inlined.Evaluate(lambda[i]), values[i]);
    EXPECT_FLOAT_EQ(inlined.Evaluate(425), 1.5f);
    EXPECT_FLOAT_EQ(inlined.Evaluate(600), 2.5f);
    EXPECT_EQ(inlined.MaxValue(), 3);

    PiecewiseLinearSpectrum extended = PiecewiseLinearSpectrum::Extended(lambda, values);
    EXPECT_EQ(extended.Evaluate(360), 1);
    EXPECT_EQ(extended.Evaluate(830), 2);
    EXPECT_FLOAT_EQ(extended.Evaluate(425), 1.5f);
    extended.Scale(2);
    EXPECT_EQ(extended.Evaluate(830), 4);
    EXPECT_EQ(extended.MaxValue(), 6);

    EXPECT_EQ(PiecewiseLinearSpectrum({500}, {2}).Evaluate(500), 2);
    EXPECT_EQ(PiecewiseLinearSpectrum({}, {}).Evaluate(500), 0);
}

TEST(Spectrum, PiecewiseLinearFindsItsIntervalAmongFewAndMany) {
    Rng rng(SeedOf(FullTestName()));
    for (const float step : {90.f, 7.f, 1.f, 0.37f, 0.002f}) {
        // Up and down, so that a wrong interval shows.
        std::vector<float> lambda, values;
        for (float at = 300 + step * rng.Uniform(); at < 900; at += step * (0.5f + rng.Uniform())) {
            lambda.push_back(at);
            values.push_back(lambda.size() % 2 ? 1.f : 2.f);
        }
        const PiecewiseLinearSpectrum zigzag(lambda, values);
        for (int i = 0; i < 2000; ++i) {
            const float at = i % 10 == 0 ? std::floor(350 + 500 * rng.Uniform()) : 310 + 580 * rng.Uniform();
            if (at < lambda.front() || at > lambda.back()) continue;
            const auto above = std::upper_bound(lambda.begin(), lambda.end() - 1, at);
            const auto k = size_t(std::max<std::ptrdiff_t>(above - lambda.begin(), 1)) - 1;
            const float t = (at - lambda[k]) / (lambda[k + 1] - lambda[k]);
            EXPECT_FLOAT_EQ(zigzag.Evaluate(at), Lerp(t, values[k], values[k + 1])) << step << " " << at;
        }
        for (const size_t k : {size_t(0), lambda.size() / 2, lambda.size() - 1})
            EXPECT_EQ(zigzag.Evaluate(lambda[k]), values[k]);
    }
}

TEST(Spectrum, PiecewiseLinearOfManySamplesEndsWhereTheyEnd) {
    // At a whole nanometre and between two: nothing of the ends is drawn out to zero.
    for (const float first : {400.f, 400.25f}) {
        std::vector<float> lambda;
        for (int i = 0; i <= 40; ++i) lambda.push_back(first + float(i));
        const PiecewiseLinearSpectrum flat(lambda, std::vector<float>(lambda.size(), 3));
        for (const float outside : {-10.f, -1.f, -0.7f, -0.1f, 40.1f, 40.7f, 41.f, 50.f})
            EXPECT_EQ(flat.Evaluate(first + outside), 0) << first << " " << outside;
        for (const float inside : {0.f, 0.1f, 0.7f, 20.3f, 39.1f, 39.9f, 40.f})
            EXPECT_EQ(flat.Evaluate(first + inside), 3) << first << " " << inside;
        EXPECT_EQ(flat.Sample(SampledWavelengths::SampleUniform(0.5f, 410, 420))[3], 3);
    }
    // A ramp, of which slopes have to follow as well.
    std::vector<float> lambda, values;
    for (int i = 0; i < 18; ++i) {
        lambda.push_back(300 + 10 * float(i));
        values.push_back(float(i));
    }
    PiecewiseLinearSpectrum ramp(lambda, values);
    ramp.Scale(3);
    for (const float at : {300.f, 365.f, 369.25f, 370.f, 455.5f, 460.75f, 470.f})
        EXPECT_FLOAT_EQ(ramp.Evaluate(at), 3 * (at - 300) / 10) << at;
}

TEST(Spectrum, DenseOnesAreLookedUpAtTheNearestNanometre) {
    const DenselySampledSpectrum dense([](float lambda) { return lambda; });
    EXPECT_EQ(dense.Evaluate(500.4f), 500);
    EXPECT_EQ(dense.Evaluate(500.6f), 501);
    EXPECT_EQ(dense.Evaluate(360), 360);
    EXPECT_EQ(dense.Evaluate(830), 830);
    EXPECT_EQ(dense.Evaluate(358), 0);
    EXPECT_EQ(dense.Evaluate(831), 0);
    EXPECT_EQ(dense.MaxValue(), 830);
    const SampledWavelengths lambda = SampledWavelengths::SampleVisible(0.77f);
    for (int i = 0; i < kNumWavelengths; ++i)
        EXPECT_EQ(dense.Sample(lambda)[i], std::floor(lambda[i] + 0.5f));
}

TEST(Spectrum, SampleAgreesWithEvaluate) {
    const SampledWavelengths lambda = SampledWavelengths::SampleVisible(0.13f);
    const PiecewiseLinearSpectrum linear({300, 550, 900}, {1, 4, 2});
    const BlackbodySpectrum blackbody(4000);
    for (const Spectrum* s :
         {static_cast<const Spectrum*>(&linear), static_cast<const Spectrum*>(&blackbody)})
        for (int i = 0; i < kNumWavelengths; ++i) EXPECT_EQ(s->Sample(lambda)[i], s->Evaluate(lambda[i]));
    EXPECT_TRUE(ConstantSpectrum(1).IsConstant());
    EXPECT_FALSE(linear.IsConstant());
}

}  // namespace
}  // namespace lacquer::spectrum_test
