#include "pbrt/core/color_space.h"

#include <gtest/gtest.h>

#include "pbrt/core/rng.h"
#include "support/statistics.h"

namespace lacquer::color_space_test {
namespace {

using test::FullTestName;
using test::SeedOf;

void ExpectNear(Vec3 a, Vec3 b, float tolerance) {
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], tolerance) << "component " << c;
}
std::vector<const ColorSpace*> Spaces() {
    std::vector<const ColorSpace*> spaces;
    for (const std::string& name : ColorSpace::Names()) spaces.push_back(ColorSpace::Find(name));
    return spaces;
}
/// The product of two spectra.
class Product final : public Spectrum {
  public:
    Product(const Spectrum& a, const Spectrum& b) : a_(a), b_(b) {}
    float Evaluate(float lambda) const override { return a_.Evaluate(lambda) * b_.Evaluate(lambda); }
    float MaxValue() const override { return a_.MaxValue() * b_.MaxValue(); }

  private:
    const Spectrum &a_, &b_;
};
/// What a reflectance looks like under the white of its colour space.
RGB Appearance(const Spectrum& reflectance, const ColorSpace& space) {
    return space.ToRGB(SpectrumToXYZ(Product(reflectance, space.Illuminant())));
}
/// What a light of this shape looks like when it has been normalised to unit luminance.
RGB LightColor(const Spectrum& emission, const ColorSpace& space) {
    const XYZ xyz = SpectrumToXYZ(emission);
    return space.ToRGB(xyz / xyz.y);
}

TEST(ColorSpace, AreFoundByNameWhateverTheCase) {
    EXPECT_EQ(ColorSpace::Names(), (std::vector<std::string>{"srgb", "dci-p3", "rec2020", "aces2065-1"}));
    EXPECT_EQ(ColorSpace::Find("sRGB"), &ColorSpace::SRGB());
    EXPECT_NE(ColorSpace::Find("DCI-P3"), nullptr);
    EXPECT_EQ(ColorSpace::Find("srg"), nullptr);
    EXPECT_EQ(ColorSpace::Find("srgbx"), nullptr);
    EXPECT_EQ(ColorSpace::Find(""), nullptr);
}

TEST(ColorSpace, ItsWhiteIsOneOneOne) {
    for (const ColorSpace* space : Spaces()) {
        SCOPED_TRACE(space->Name());
        EXPECT_NEAR(InnerProduct(space->Illuminant(), CieY()), kCieYIntegral, 1e-3f);
        ExpectNear(space->ToRGB(SpectrumToXYZ(space->Illuminant())), RGB(1), 1e-5f);
        const XYZ white = space->ToXYZ(RGB(1));
        EXPECT_NEAR(white.y, 1, 1e-6f);
        EXPECT_NEAR(Chromaticity(white).x, space->White().x, 1e-6f);
        EXPECT_NEAR(Chromaticity(white).y, space->White().y, 1e-6f);
        EXPECT_NEAR(space->Luminance(RGB(1)), 1, 1e-6f);
    }
    // The standards' white points: D65, and the D60-like one of ACES.
    for (const char* name : {"srgb", "dci-p3", "rec2020"}) {
        EXPECT_NEAR(ColorSpace::Find(name)->White().x, 0.3127f, 2e-4f);
        EXPECT_NEAR(ColorSpace::Find(name)->White().y, 0.3290f, 2e-4f);
    }
    EXPECT_NEAR(ColorSpace::Find("aces2065-1")->White().x, 0.32168f, 3e-4f);
    EXPECT_NEAR(ColorSpace::Find("aces2065-1")->White().y, 0.33767f, 3e-4f);
}

TEST(ColorSpace, ItsPrimariesAreThoseOfTheStandard) {
    const std::vector<std::vector<float>> primaries = {{.64f, .33f, .3f, .6f, .15f, .06f},
                                                       {.68f, .32f, .265f, .69f, .15f, .06f},
                                                       {.708f, .292f, .17f, .797f, .131f, .046f},
                                                       {.7347f, .2653f, 0, 1, .0001f, -.077f}};
    const auto spaces = Spaces();
    for (size_t s = 0; s < spaces.size(); ++s)
        for (int c = 0; c < 3; ++c) {
            RGB rgb(0);
            rgb[c] = 1;
            const Point2 xy = Chromaticity(spaces[s]->ToXYZ(rgb));
            EXPECT_NEAR(xy.x, primaries[s][size_t(2 * c)], 1e-5f) << spaces[s]->Name();
            EXPECT_NEAR(xy.y, primaries[s][size_t(2 * c + 1)], 1e-5f) << spaces[s]->Name();
            EXPECT_EQ(spaces[s]->Chromaticities()[2 * c], primaries[s][size_t(2 * c)]);
        }
    // Rec. 709 luma weights.
    EXPECT_NEAR(ColorSpace::SRGB().Luminance({1, 0, 0}), 0.2126f, 2e-4f);
    EXPECT_NEAR(ColorSpace::SRGB().Luminance({0, 1, 0}), 0.7152f, 2e-4f);
    EXPECT_NEAR(ColorSpace::SRGB().Luminance({0, 0, 1}), 0.0722f, 2e-4f);
}

TEST(ColorSpace, MatricesAreInverse) {
    Rng rng(SeedOf(FullTestName()));
    for (const ColorSpace* space : Spaces()) {
        const RGB rgb(rng.Uniform(), rng.Uniform(), rng.Uniform());
        ExpectNear(space->ToRGB(space->ToXYZ(rgb)), rgb, 2e-6f);
    }
}

TEST(ColorSpace, ChromaticitiesFindTheirSpace) {
    for (const ColorSpace* space : Spaces()) {
        float c[8];
        std::copy_n(space->Chromaticities(), 8, c);
        EXPECT_EQ(ColorSpace::FromChromaticities(c), space);
        c[2] += 5e-4f;
        EXPECT_EQ(ColorSpace::FromChromaticities(c), space);
        c[2] += 0.01f;
        EXPECT_EQ(ColorSpace::FromChromaticities(c), nullptr);
    }
}

struct RoundTripErrors {
    double mean = 0, max = 0;
};
/// Of random colours of which the component sizes lie in [low, high], in an albedo's way from RGB to RGB.
RoundTripErrors RoundTrip(const ColorSpace& space, float low, float high, uint64_t seed) {
    constexpr int kColors = 1500;
    Rng rng(seed);
    RoundTripErrors errors;
    for (int i = 0; i < kColors; ++i) {
        const RGB rgb(Lerp(rng.Uniform(), low, high), Lerp(rng.Uniform(), low, high),
                      Lerp(rng.Uniform(), low, high));
        const RGB seen = Appearance(*space.MakeSpectrum(rgb, SpectrumKind::Albedo), space);
        for (int c = 0; c < 3; ++c) {
            const double error = std::abs(double(seen[c]) - double(rgb[c]));
            errors.mean += error / (3 * kColors);
            errors.max = std::max(errors.max, error);
        }
    }
    return errors;
}

TEST(ColorSpace, RandomColorsReturnFromTheirSpectra) {
    // The table interpolates a fit: measured for sRGB are 2.1e-4 on average and 7.5e-3 at worst.
    const RoundTripErrors errors = RoundTrip(ColorSpace::SRGB(), 0, 1, SeedOf(FullTestName()));
    EXPECT_LT(errors.mean, 5e-4);
    EXPECT_LT(errors.max, 2e-2);
}

TEST(ColorSpace, MutedColorsReturnFromTheirSpectraInEverySpace) {
    // Saturated colours of the wide gamuts are no reflectances at all; muted ones are.
    for (const ColorSpace* space : Spaces()) {
        const RoundTripErrors errors = RoundTrip(*space, 0.3f, 0.7f, SeedOf(FullTestName()));
        EXPECT_LT(errors.mean, 5e-4) << space->Name();
        EXPECT_LT(errors.max, 5e-3) << space->Name();
    }
}

TEST(ColorSpace, NormalizedLightsHaveTheCheckedColors) {
    const PiecewiseLinearSpectrum flat({300, 900}, {5, 5});
    // As the format's reference has them, from renderings with an error of up to 0.003.
    ExpectNear(LightColor(flat, ColorSpace::SRGB()), {1.2045f, 0.9483f, 0.9068f}, 3e-3f);
    ExpectNear(LightColor(BlackbodySpectrum(3000), ColorSpace::SRGB()), {1.771f, 0.844f, 0.271f}, 3e-3f);
    // XYZ = (1, 1, 1) through the inverse of the standard's matrix; its digits and the observer's are good to
    // 5e-4.
    ExpectNear(LightColor(flat, ColorSpace::SRGB()), {1.20478f, 0.94830f, 0.90884f}, 5e-4f);
}

TEST(ColorSpace, GreysAreExactlyFlat) {
    for (const ColorSpace* space : Spaces())
        for (const float grey : {0.f, 0.01f, 0.18f, 0.5f, 0.77f, 1.f}) {
            for (const SpectrumKind kind : {SpectrumKind::Albedo, SpectrumKind::Unbounded}) {
                const auto spectrum = space->MakeSpectrum(RGB(grey), kind);
                EXPECT_TRUE(spectrum->IsConstant());
                EXPECT_EQ(spectrum->Evaluate(400), grey);
                const SampledWavelengths lambda = SampledWavelengths::SampleVisible(0.3f);
                EXPECT_EQ(SampleRGB(*space, RGB(grey), kind, lambda), SampledSpectrum(grey));
            }
            const SigmoidPolynomial polynomial = space->ToPolynomial(RGB(grey));
            for (const float lambda : {360.f, 555.f, 830.f})
                EXPECT_NEAR(polynomial.Evaluate(lambda), grey, 1e-6f);
        }
    EXPECT_EQ(ColorSpace::SRGB().MakeSpectrum(RGB(7), SpectrumKind::Unbounded)->Evaluate(500), 7);
}

TEST(ColorSpace, GreyLightsAreScaledWhite) {
    for (const ColorSpace* space : Spaces()) {
        const auto light = space->MakeSpectrum(RGB(3), SpectrumKind::Illuminant);
        for (float lambda = 360; lambda <= 830; lambda += 10)
            EXPECT_NEAR(light->Evaluate(lambda), 3 * space->Illuminant().Evaluate(lambda), 1e-5f);
    }
}

TEST(ColorSpace, KindsScaleAsTheyShould) {
    const ColorSpace& space = ColorSpace::SRGB();
    const RGB rgb(0.6f, 3, 1.2f);
    // Unbounded: 2 m times the polynomial of rgb / (2 m); as a reflectance it looks like rgb.
    ExpectNear(Appearance(*space.MakeSpectrum(rgb, SpectrumKind::Unbounded), space), rgb, 6 * 1e-3f);
    const auto light = space.MakeSpectrum(rgb, SpectrumKind::Illuminant);
    ExpectNear(space.ToRGB(SpectrumToXYZ(*light)), rgb, 6 * 1e-3f);
    EXPECT_EQ(space.MakeSpectrum(RGB(0), SpectrumKind::Illuminant)->Evaluate(500), 0);
}

TEST(ColorSpace, SampleRgbAgreesWithMakeSpectrum) {
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 300; ++i) {
        const RGB rgb(rng.Uniform(), rng.Uniform(), i % 5 ? rng.Uniform() : 0.f);
        const SampledWavelengths lambda = SampledWavelengths::SampleVisible(rng.Uniform());
        for (const SpectrumKind kind :
             {SpectrumKind::Albedo, SpectrumKind::Unbounded, SpectrumKind::Illuminant}) {
            const auto spectrum = ColorSpace::SRGB().MakeSpectrum(rgb, kind);
            const SampledSpectrum a = SampleRGB(ColorSpace::SRGB(), rgb, kind, lambda),
                                  b = spectrum->Sample(lambda);
            for (int k = 0; k < kNumWavelengths; ++k) {
                EXPECT_NEAR(a[k], b[k], 1e-6f * std::max(1.f, b[k]));
                // The polynomial of a large lambda^2 cancels: x is off by 1e-7 of terms up to 200.
                EXPECT_NEAR(b[k], spectrum->Evaluate(lambda[k]), 1e-4f * std::max(1.f, b[k]));
            }
        }
    }
}

TEST(SigmoidPolynomial, MaxValueIsALowUpperBound) {
    Rng rng(SeedOf(FullTestName()));
    for (int i = 0; i < 300; ++i) {
        const SigmoidPolynomial p =
            ColorSpace::SRGB().ToPolynomial({rng.Uniform(), rng.Uniform(), rng.Uniform()});
        float largest = 0;
        for (float lambda = 360; lambda <= 830; lambda += 0.25f)
            largest = std::max(largest, p.Evaluate(lambda));
        EXPECT_GE(p.MaxValue(), largest - 1e-5f);
        EXPECT_LE(p.MaxValue(), largest + 1e-3f);
    }
    EXPECT_EQ((SigmoidPolynomial{0, 0, Infinity}).MaxValue(), 1);
    EXPECT_EQ((SigmoidPolynomial{0, 0, -Infinity}).MaxValue(), 0);
    EXPECT_NEAR((SigmoidPolynomial{0, 0.01f, -5}).MaxValue(), 0.5f + 3.3f / 2 / std::sqrt(1 + 3.3f * 3.3f),
                1e-5f);
}

TEST(WhiteBalance, IsTheIdentityBetweenEqualWhites) {
    const Point2 d65 = ColorSpace::SRGB().White();
    const glm::mat3 m = WhiteBalance(d65, d65);
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) EXPECT_NEAR(m[c][r], c == r ? 1 : 0, 1e-6f);
}

TEST(WhiteBalance, IsBradfordsMatrix) {
    // D50 (0.96422, 1, 0.82521) to D65 (0.95047, 1, 1.08883), as tabulated for the Bradford cones.
    const glm::mat3 m =
        WhiteBalance(Chromaticity({0.96422f, 1, 0.82521f}), Chromaticity({0.95047f, 1, 1.08883f}));
    const float expected[3][3] = {{0.9555766f, -0.0230393f, 0.0631636f},
                                  {-0.0282895f, 1.0099416f, 0.0210077f},
                                  {0.0122982f, -0.0204830f, 1.3299098f}};
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(m[c][r], expected[r][c], 2e-5f);
}

TEST(WhiteBalance, TakesTheOneWhiteToTheOther) {
    const Point2 from(0.45f, 0.41f), to(0.31f, 0.33f);
    ExpectNear(WhiteBalance(from, to) * FromChromaticity(from, 1), FromChromaticity(to, 1), 1e-5f);
}

TEST(Daylight, HasTheChromaticityOfItsTemperature) {
    // The locus itself; the temperature is on the radiation constant of 1968. 2e-4: the components have 5 nm
    // steps.
    for (const float kelvin : {4500.f, 5500.f, 6500.f, 10000.f, 20000.f}) {
        const double t = double(kelvin) * 1.4388 / 1.4380;
        const double x = t <= 7000 ? 0.244063 + 0.09911e3 / t + 2.9678e6 / (t * t) - 4.6070e9 / (t * t * t)
                                   : 0.237040 + 0.24748e3 / t + 1.9018e6 / (t * t) - 2.0064e9 / (t * t * t);
        const double y = -3 * x * x + 2.870 * x - 0.275;
        const Point2 xy = Chromaticity(SpectrumToXYZ(*DaylightSpectrum(kelvin)));
        EXPECT_NEAR(double(xy.x), x, 2e-4) << kelvin;
        EXPECT_NEAR(double(xy.y), y, 2e-4) << kelvin;
    }
    // Below 4000 K a black body.
    const Point2 warm = Chromaticity(SpectrumToXYZ(*DaylightSpectrum(3000)));
    const Point2 planck = Chromaticity(SpectrumToXYZ(BlackbodySpectrum(3000 * 1.4388f / 1.4380f)));
    EXPECT_NEAR(warm.x, planck.x, 1e-5f);
}

TEST(Chromaticity, GoesBothWays) {
    ExpectNear(FromChromaticity(Chromaticity({0.3f, 0.5f, 0.9f}), 0.5f), {0.3f, 0.5f, 0.9f}, 1e-6f);
    EXPECT_EQ(Chromaticity(XYZ(0)), Point2(0));
    EXPECT_EQ(FromChromaticity({0.3f, 0}, 1), XYZ(0));
}

}  // namespace
}  // namespace lacquer::color_space_test
