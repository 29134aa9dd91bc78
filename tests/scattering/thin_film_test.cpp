#include "pbrt/scattering/thin_film.h"

#include <gtest/gtest.h>

#include <complex>
#include <numbers>

#include "pbrt/core/rng.h"
#include "pbrt/film/estimate_xyz.h"
#include "pbrt/scattering/fresnel.h"
#include "support/lanes.h"

namespace lacquer::thin_film_test {
namespace {

using test::Lanes;

using Complex = std::complex<double>;

// ---- The characteristic matrix, in double precision: the usual computation of optical coatings
// --------------

struct Layers {
    double above = 1;
    Complex film{1.5, 0};
    double thickness = 0;
    Complex below{1.5, 0};
};
struct Energy {
    double reflected, transmitted;
};

/// Cosine of a medium's wave, of the branch that does not grow.
Complex CosineIn(const Complex& index, double s) {
    const Complex sine = s / index;
    Complex normal = index * std::sqrt(1.0 - sine * sine);
    if (normal.imag() < 0 || (normal.imag() == 0 && normal.real() < 0)) normal = -normal;
    return normal / index;
}

/// From above, for one polarisation. @param s  index above times sine
Energy OfPolarization(const Layers& l, double s, double lambda, bool isParallel) {
    const Complex cosAbove = CosineIn(l.above, s), cosFilm = CosineIn(l.film, s),
                  cosBelow = CosineIn(l.below, s);
    const auto admittance = [&](const Complex& index, const Complex& cosine) {
        return isParallel ? index / cosine : index * cosine;
    };
    const Complex above = admittance(l.above, cosAbove), film = admittance(l.film, cosFilm),
                  below = admittance(l.below, cosBelow);
    const Complex phase = 2 * std::numbers::pi * l.film * cosFilm * l.thickness / lambda, i(0, 1);
    const Complex b = std::cos(phase) - i * std::sin(phase) / film * below;
    const Complex c = -i * film * std::sin(phase) + std::cos(phase) * below;
    const Complex sum = above * b + c;
    return {std::norm((above * b - c) / sum), 4 * above.real() * below.real() / std::norm(sum)};
}

Energy ByMatrix(const Layers& l, double cosTheta, double lambda) {
    const double s = l.above * std::sqrt(1 - cosTheta * cosTheta);
    const Energy a = OfPolarization(l, s, lambda, false), b = OfPolarization(l, s, lambda, true);
    return {(a.reflected + b.reflected) / 2, (a.transmitted + b.transmitted) / 2};
}
/// The same layers from the other side.
Layers Reversed(const Layers& l) { return {l.below.real(), l.film, l.thickness, l.above}; }

ThinFilm FilmOf(const Layers& l, SampledSpectrum lambda) {
    return {float(l.thickness), SampledSpectrum(float(l.film.real())), SampledSpectrum(float(l.film.imag())),
            lambda, float(l.above)};
}
/// Several of them at once, over the whole range.
template <class Function>
void ForWavelengths(const Function& function) {
    for (float first = 360; first <= 715; first += 23.5f)
        function(Lanes(first, first + 31, first + 67, first + 115));
}
constexpr double kDegrees = std::numbers::pi / 180;
const double kAngles[] = {0, 1, 20, 40, 41.5, 45, 48.6, 56.31, 70, 80, 85, 88, 89};

/// Largest difference of a share from the matrix, from both sides.
double LargestError(const Layers& l) {
    double largest = 0;
    const auto eta = float(l.below.real() / l.above);
    ForWavelengths([&](SampledSpectrum lambda) {
        const ThinFilm film = FilmOf(l, lambda);
        for (const double angle : kAngles)
            for (const bool isFromBelow : {false, true}) {
                // What the float is, not what it was made of.
                const auto c = float(std::cos(angle * kDegrees));
                const ThinFilm::Shares shares = film.OnDielectric(isFromBelow ? -c : c, eta);
                for (int i = 0; i < kNumWavelengths; ++i) {
                    const Energy expected =
                        ByMatrix(isFromBelow ? Reversed(l) : l, double(c), double(lambda[i]));
                    largest = std::max({largest, std::abs(double(shares.reflected[i]) - expected.reflected),
                                        std::abs(double(shares.transmitted[i]) - expected.transmitted)});
                }
            }
    });
    return largest;
}

// Indices are multiples of 2^-10, so that floats hold them.
constexpr double k15 = 1.5, k133 = 1.3330078125, k138 = 1.3798828125;

TEST(ThinFilm, OnDielectricAgreesWithTheMatrix) {
    for (const double thickness : {1., 50., 99.5, 300., 1200., 4000.})
        for (const double film : {1.25, k133, k138, 2.5})
            EXPECT_LT(LargestError({1, film, thickness, k15}), 1e-5) << thickness << ' ' << film;
}

TEST(ThinFilm, BetweenEqualMediaAgreesWithTheMatrix) {
    for (const double thickness : {10., 120., 500., 2000.})
        EXPECT_LT(LargestError({1, k133, thickness, 1}), 1e-5) << thickness;
}

// Light that no wave of the film could carry tunnels through it: a gap of air between glass and glass.
TEST(ThinFilm, LightTunnelsThroughThinGaps) {
    for (const double thickness : {20., 150., 600.})
        EXPECT_LT(LargestError({k15, 1, thickness, 1.75}), 1e-5) << thickness;
    const ThinFilm gap = FilmOf({k15, 1, 100, k15}, SampledSpectrum(550));
    EXPECT_GT(gap.OnDielectric(std::cos(float(45 * kDegrees)), 1).transmitted[0], 0.1f);
}

TEST(ThinFilm, AbsorbingFilmsAgreeWithTheMatrix) {
    for (const double k : {1e-3, 0.125, 2.})
        for (const double thickness : {5., 100., 700.})
            for (const double below : {1., k15}) {
                EXPECT_LT(LargestError({1, {2.5, k}, thickness, below}), 1e-5) << k << ' ' << thickness;
                EXPECT_LT(LargestError({k133, {0.25, k}, thickness, below}), 1e-5) << k << ' ' << thickness;
            }
}

// Phases of a thousand turns keep their digits.
TEST(ThinFilm, ThickFilmsAgreeWithTheMatrix) {
    for (const double k : {0., 1e-4, 1e-3})
        for (const double thickness : {20000., 100000.})
            EXPECT_LT(LargestError({1, {2.5, k}, thickness, k15}), 1e-5) << k << ' ' << thickness;
}

TEST(ThinFilm, InsideAStackAgreesWithTheMatrix) {
    for (const double thickness : {80., 450., 1500.})
        EXPECT_LT(LargestError({k15, 1.75, thickness, 1.25}), 1e-5) << thickness;
}

TEST(ThinFilm, OnMetalAgreesWithTheMatrix) {
    for (const double above : {1., k15})
        for (const Complex metal : {Complex(0.25, 3.5), Complex(2.75, 3.25), Complex(1.5, 0.0078125)})
            for (const Complex film : {Complex(1.5, 0), Complex(2.5, 0.25), Complex(1.25, 0)})
                for (const double thickness : {10., 90., 300., 2500.}) {
                    const Layers l{above, film, thickness, metal};
                    ForWavelengths([&](SampledSpectrum lambda) {
                        for (const double angle : kAngles) {
                            const auto c = float(std::cos(angle * kDegrees));
                            const SampledSpectrum r =
                                FilmOf(l, lambda).OnConductor(c, SampledSpectrum(float(metal.real() / above)),
                                                              SampledSpectrum(float(metal.imag() / above)));
                            for (int i = 0; i < kNumWavelengths; ++i)
                                ASSERT_NEAR(double(r[i]), ByMatrix(l, double(c), double(lambda[i])).reflected,
                                            1e-5)
                                    << above << metal << film << thickness << ' ' << angle;
                        }
                    });
                }
}

// The comparison sees a nanometre, a hundredth of the index, and polarisations that are not averaged.
TEST(ThinFilm, NegativeControls) {
    const Layers l{1, k138, 300, k15};
    const auto differs = [&](const Layers& other, double angle) {
        const double c = std::cos(angle * kDegrees);
        return std::abs(ByMatrix(l, c, 550).reflected - ByMatrix(other, c, 550).reflected) > 1e-5;
    };
    EXPECT_TRUE(differs({1, k138, 301, k15}, 20));
    EXPECT_TRUE(differs({1, k138 + 0.01, 300, k15}, 20));
    const double s = std::sin(60 * kDegrees);
    EXPECT_GT(OfPolarization(l, s, 550, false).reflected - OfPolarization(l, s, 550, true).reflected, 1e-2);
}

// ---- Closed forms ---------------------------------------------------------------------------------------

TEST(ThinFilm, QuarterWavesAtNormalIncidence) {
    // R = ((n0 n2 - n1^2) / (n0 n2 + n1^2))^2, 0 where n1^2 = n0 n2.
    for (const float film : {1.25f, 1.5f, 2.25f}) {
        const float below = 1.5625f;
        const ThinFilm coat(550 / (4 * film), SampledSpectrum(film), SampledSpectrum(0), SampledSpectrum(550),
                            1);
        const float expected = Sqr((below - film * film) / (below + film * film));
        EXPECT_NEAR(coat.OnDielectric(1, below).reflected[0], expected, 1e-6f) << film;
        EXPECT_NEAR(coat.OnDielectric(-1, below).reflected[0], expected, 1e-6f) << film;
    }
    // On a metal: r of the film over the metal is turned by half a wave.
    const Complex metal(0.25, 3.5), bottom = (1.5 - metal) / (1.5 + metal),
                                    r = (-0.2 - bottom) / (1.0 + 0.2 * bottom);
    const ThinFilm coat(550 / 6.f, SampledSpectrum(1.5f), SampledSpectrum(0), SampledSpectrum(550), 1);
    EXPECT_NEAR(coat.OnConductor(1, SampledSpectrum(0.25f), SampledSpectrum(3.5f))[0], float(std::norm(r)),
                1e-6f);
}

TEST(ThinFilm, SoapFilmsVanishWhereTheyAreThin) {
    // Both sides reflect with opposite signs: black at first, then as 16 times one of them at a quarter wave.
    const auto reflected = [](float thickness) {
        return ThinFilm(thickness, SampledSpectrum(1.33f), SampledSpectrum(0), SampledSpectrum(550), 1)
            .OnDielectric(1, 1)
            .reflected[0];
    };
    EXPECT_LT(reflected(1), 1e-4f);
    const float single = Sqr(0.33f / 2.33f);
    EXPECT_NEAR(reflected(550 / (4 * 1.33f)), 4 * single / Sqr(1 + single), 1e-6f);
    EXPECT_LT(reflected(550 / (2 * 1.33f)), 1e-9f);
}

TEST(ThinFilm, OfTheIndexBelowIsNoFilm) {
    for (float c = 0.02f; c <= 1; c += 0.02f) {
        const ThinFilm film(400, SampledSpectrum(1.5f), SampledSpectrum(0), SampledSpectrum(500), 1);
        EXPECT_NEAR(film.OnDielectric(c, 1.5f).reflected[1], FresnelDielectric(c, 1.5f), 2e-6f);
        EXPECT_NEAR(film.OnDielectric(-c, 1.5f).reflected[1], FresnelDielectric(-c, 1.5f), 2e-6f);
        const SampledSpectrum eta(0.25f), k(3.5f);
        const ThinFilm metal(400, eta, k, SampledSpectrum(500), 1);
        EXPECT_NEAR(metal.OnConductor(c, eta, k)[2], FresnelConductor(c, eta, k)[2], 1e-5f);
    }
}

// ---- Energy and extremes
// ------------------------------------------------------------------------------------

TEST(ThinFilm, KeepsEnergyAndIsReciprocal) {
    Rng rng(3);
    for (int trial = 0; trial < 20000; ++trial) {
        const auto between = [&](float low, float high) { return low * std::pow(high / low, rng.Uniform()); };
        const float above = trial % 3 ? 1.f : between(1, 2), eta = between(0.4f, 2.5f);
        const bool absorbs = trial % 2 == 1;
        const SampledSpectrum lambda = SampledWavelengths::SampleVisible(rng.Uniform()).Lambda();
        const ThinFilm film(between(0.1f, 5000), SampledSpectrum(between(0.3f, 4)),
                            SampledSpectrum(absorbs ? between(1e-4f, 10) : 0), lambda, above);
        const float c = trial % 5 ? rng.Uniform() : between(1e-6f, 0.1f);
        const ThinFilm::Shares down = film.OnDielectric(c, eta);
        ASSERT_TRUE(down.reflected.IsValid() && down.transmitted.IsValid());
        for (int i = 0; i < kNumWavelengths; ++i) {
            const float sum = down.reflected[i] + down.transmitted[i];
            ASSERT_LE(sum, 1 + 1e-6f);
            if (!absorbs) {
                ASSERT_NEAR(sum, 1, 1e-6f);
            }
        }
        // The way back along the refracted ray lets as much through.
        const float cos2 = 1 - (1 - c) * (1 + c) / (eta * eta);
        if (cos2 < 1e-2f || c < 0.05f) continue;  // where the float of a cosine has too few digits
        const ThinFilm::Shares up = film.OnDielectric(-std::sqrt(cos2), eta);
        for (int i = 0; i < kNumWavelengths; ++i) ASSERT_NEAR(up.transmitted[i], down.transmitted[i], 2e-4f);
    }
}

TEST(ThinFilm, StaysFiniteAtExtremes) {
    for (const float thickness : {1e-3f, 1.f, kMaxFilmThickness})
        for (const float n : {1e-3f, 1.f, 1e3f})
            for (const float k : {0.f, 1e-20f, 1.f, 1e6f})
                for (const float other : {1e-3f, 1.f, 1e3f})
                    for (const float c : {0.f, 1e-20f, 1e-4f, 0.5f, 1.f, 1.0000001f}) {
                        const ThinFilm film(thickness, SampledSpectrum(n), SampledSpectrum(k),
                                            SampledWavelengths::SampleVisible(0.3f).Lambda(),
                                            other == 1 ? 1.5f : 1);
                        for (const float side : {1.f, -1.f}) {
                            const ThinFilm::Shares s = film.OnDielectric(side * c, other);
                            EXPECT_TRUE(s.reflected.IsValid() && s.transmitted.IsValid() &&
                                        (s.reflected + s.transmitted).MaxComponent() <= 1 + 1e-6f)
                                << thickness << ' ' << n << ' ' << k << ' ' << other << ' ' << side * c;
                        }
                        const SampledSpectrum r =
                            film.OnConductor(c, SampledSpectrum(other), SampledSpectrum(k));
                        EXPECT_TRUE(r.IsValid() && r.MaxComponent() <= 1)
                            << thickness << ' ' << n << ' ' << k << ' ' << other << ' ' << c;
                    }
}

// ---- Colours from the wavelengths of a path

constexpr int kSamples = 64;  ///< of a pixel

XYZ ReflectedColor(float thickness, const SampledWavelengths& lambda) {
    const ThinFilm soap(thickness, SampledSpectrum(1.33f), SampledSpectrum(0), lambda.Lambda(), 1);
    return EstimateXYZ(soap.OnDielectric(1, 1).reflected, lambda);
}
/// By millions of equally spaced wavelengths.
XYZ ExhaustiveColor(float thickness) {
    constexpr int kSteps = 1 << 20;
    glm::dvec3 sum(0);
    for (int i = 0; i < kSteps; ++i)
        sum +=
            glm::dvec3(ReflectedColor(thickness, SampledWavelengths::SampleUniform(
                                                     (float(i) + 0.5f) / float(kNumWavelengths * kSteps))));
    return XYZ(sum / double(kSteps));
}

/// Root mean square error of the luminance of a pixel over its mean, and what is left of it in the mean of
/// all pixels, in standard errors.
struct ColorErrors {
    double relative, biasInErrors;
};
template <class Draw>
ColorErrors ErrorsOf(float thickness, const Draw& draw) {
    const auto expected = double(ExhaustiveColor(thickness).y);
    constexpr int kPixels = 2000;
    Rng rng(11);
    double sum = 0, sum2 = 0;
    for (int pixel = 0; pixel < kPixels; ++pixel) {
        double mean = 0;
        for (int i = 0; i < kSamples; ++i) mean += double(draw(i, rng, thickness)) / kSamples;
        sum += mean - expected;
        sum2 += Sqr(mean - expected);
    }
    return {std::sqrt(sum2 / kPixels) / expected, std::abs(sum) / std::sqrt(sum2)};
}
/// As the samplers have it: the samples of a pixel in turn, the wavelengths of each spread over the range.
float Stratified(int i, Rng& rng, float thickness) {
    return ReflectedColor(thickness, SampledWavelengths::SampleVisible((float(i) + rng.Uniform()) / kSamples))
        .y;
}
/// As if each wavelength were drawn by itself.
float Unstratified(int, Rng& rng, float thickness) {
    float sum = 0;
    for (int k = 0; k < kNumWavelengths; ++k) {
        const float lambda = SampleVisibleWavelength(rng.Uniform());
        const ThinFilm soap(thickness, SampledSpectrum(1.33f), SampledSpectrum(0), SampledSpectrum(lambda),
                            1);
        sum += soap.OnDielectric(1, 1).reflected[0] * CieY().Evaluate(lambda) / kCieYIntegral /
               PdfVisibleWavelength(lambda);
    }
    return sum / kNumWavelengths;
}

// Wavelengths that are spread over the range have a tenth of the noise that others have for a film of one
// fringe, and a quarter for twelve fringes; where fringes are closer than samples, they are as good as any.
TEST(ThinFilm, ColoursConvergeWithWavelengthsOfAPath) {
    for (const auto& [thickness, bound] : {std::pair{300.f, 2e-3}, {3000.f, 2e-2}, {30000.f, 0.1}}) {
        const ColorErrors spread = ErrorsOf(thickness, Stratified), apart = ErrorsOf(thickness, Unstratified);
        EXPECT_LT(spread.biasInErrors, 4.5) << thickness;
        EXPECT_LT(apart.biasInErrors, 4.5) << thickness;
        EXPECT_LT(spread.relative, bound) << thickness;
        const double gain = thickness < 1000 ? 10 : thickness < 10000 ? 4 : 1;
        EXPECT_LT(gain * spread.relative, apart.relative) << thickness;
    }
}

}  // namespace
}  // namespace lacquer::thin_film_test
