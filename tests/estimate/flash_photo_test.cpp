// The flash photograph: its reverse mode against Ceres' Jets, its values against closed forms, and tone
// curves.
#include "estimate/photo/flash_photo.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include "estimate/gradient_check.h"
#include "estimate/photo/tone.h"

namespace lacquer::estimate::flash_photo_test {
namespace {

constexpr int kSize = 16;
constexpr size_t kPoints = size_t(kSize) * kSize;
constexpr double kDistance = 21;
const MapGrid kGrid{kSize, 18, false};
const FlashSettings kSettings{900, 8, 0.4, -0.7};

/// A surface whose fields vary everywhere.
Surface RoughSurface(Reflectance reflectance) {
    Surface s;
    s.reflectance = reflectance;
    s.slopeX = RandomNumbers(kPoints, 1, -0.4, 0.4);
    s.slopeY = RandomNumbers(kPoints, 2, -0.4, 0.4);
    const bool varies = reflectance == Reflectance::Dielectric;
    for (size_t k = 0; k < 3; ++k) s.albedo[k] = RandomNumbers(varies ? kPoints : 1, 3 + k, 0.1, 0.9);
    if (varies) s.roughness = RandomNumbers(kPoints, 6, 0.2, 0.7);
    s.roughnessX = 0.45;
    s.roughnessY = 0.6;
    s.topF0 = 0.042;
    s.topRoughness = 0.4;
    s.flakeRoughness = 0.5;
    s.glowWeight = 0.3;
    s.glowF0 = 0.1;
    s.glowRoughness = 0.6;
    s.flakeF0 = {0.3, 0.4, 0.2};
    return s;
}

/// Derivatives by all that a photograph depends on, in the places of these numbers.
template <int N>
using Jet = ceres::Jet<double, N>;

/// What all pixels of a photograph depend on: settings first.
enum Place { Light, Vignette, AxisX, AxisY, SlopeX, SlopeY, FirstOwn };

template <int N>
struct JetPixel {
    FromAxis<Jet<N>> at;
    Jet<N> irradiance, slopeX, slopeY;
    JetPixel(const Surface& s, size_t i) {
        const Jet<N> light(kSettings.light, Light), vignette(kSettings.vignette, Vignette);
        at = {kGrid.X(int(i % kSize)) - Jet<N>(kSettings.axisX, AxisX),
              kGrid.Y(int(i / kSize)) - Jet<N>(kSettings.axisY, AxisY), kDistance};
        irradiance =
            light / at.SquaredDistance() * exp(-(at.x * at.x + at.y * at.y) / (2.0 * vignette * vignette));
        slopeX = Jet<N>(s.slopeX[i], SlopeX);
        slopeY = Jet<N>(s.slopeY[i], SlopeY);
    }
};

/// Compares derivatives of sum of w_ik linear_ik. Each is a sum of about kPoints numbers: rounding of 1e-13
/// relative to the largest.
class Comparison {
  public:
    explicit Comparison(const Surface& surface)
        : weights_(kSize), by_(surface.ZeroAdjoint()), settings_{0, 0, 0, 0} {
        weights_.values = RandomNumbers(3 * kPoints, 9, -1, 1);
        FlashPhoto(kGrid, kDistance, Brdf::Smith).Backward(surface, kSettings, weights_, &by_, &settings_);
    }
    double Weight(size_t i, size_t k) const { return weights_.values[k * kPoints + i]; }
    const Surface& By() const { return by_; }

    void ExpectSettings(const std::array<double, 4>& sums) const {
        Expect(settings_.light, sums[Light], "light");
        Expect(settings_.vignette, sums[Vignette], "vignette");
        Expect(settings_.axisX, sums[AxisX], "axisX");
        Expect(settings_.axisY, sums[AxisY], "axisY");
    }
    static void Expect(double value, double jet, const char* what) {
        EXPECT_NEAR(value, jet, 1e-11 * (1e-3 + std::abs(jet))) << what;
    }

  private:
    PlanarImage weights_;
    Surface by_;
    FlashSettings settings_;
};

TEST(FlashPhoto, DerivativesOfDielectricsAreThoseOfJets) {
    constexpr int kOwn = FirstOwn, kNumJets = kOwn + 4;
    const Surface s = RoughSurface(Reflectance::Dielectric);
    const Comparison comparison(s);
    std::array<double, 4> settings{};
    for (size_t i = 0; i < kPoints; ++i) {
        const JetPixel<kNumJets> pixel(s, i);
        using T = Jet<kNumJets>;
        const auto value = DielectricPixel<T>(
            Brdf::Smith, pixel.at, pixel.slopeX, pixel.slopeY, T(s.roughness[i], kOwn),
            {T(s.albedo[0][i], kOwn + 1), T(s.albedo[1][i], kOwn + 2), T(s.albedo[2][i], kOwn + 3)});
        T sum(0.);
        for (size_t k = 0; k < 3; ++k) sum += comparison.Weight(i, k) * pixel.irradiance * value[k];
        for (size_t p = 0; p < 4; ++p) settings[p] += sum.v[int(p)];
        Comparison::Expect(comparison.By().slopeX[i], sum.v[SlopeX], "slopeX");
        Comparison::Expect(comparison.By().slopeY[i], sum.v[SlopeY], "slopeY");
        Comparison::Expect(comparison.By().roughness[i], sum.v[kOwn], "roughness");
        for (size_t k = 0; k < 3; ++k)
            Comparison::Expect(comparison.By().albedo[k][i], sum.v[kOwn + 1 + int(k)], "albedo");
    }
    comparison.ExpectSettings(settings);
}

TEST(FlashPhoto, DerivativesOfMetalAreThoseOfJets) {
    constexpr int kOwn = FirstOwn, kNumJets = kOwn + 5;
    const Surface s = RoughSurface(Reflectance::Metal);
    const Comparison comparison(s);
    std::array<double, kNumJets> sums{};
    for (size_t i = 0; i < kPoints; ++i) {
        const JetPixel<kNumJets> pixel(s, i);
        using T = Jet<kNumJets>;
        const T value = MetalPixel<T>(Brdf::Smith, pixel.at, pixel.slopeX, pixel.slopeY,
                                      T(s.roughnessX, kOwn), T(s.roughnessY, kOwn + 1));
        T sum(0.);
        for (size_t k = 0; k < 3; ++k)
            sum += comparison.Weight(i, k) * pixel.irradiance * value * T(s.albedo[k][0], kOwn + 2 + int(k));
        for (size_t p = 0; p < sums.size(); ++p) sums[p] += sum.v[int(p)];
        Comparison::Expect(comparison.By().slopeX[i], sum.v[SlopeX], "slopeX");
        Comparison::Expect(comparison.By().slopeY[i], sum.v[SlopeY], "slopeY");
    }
    comparison.ExpectSettings({sums[0], sums[1], sums[2], sums[3]});
    Comparison::Expect(comparison.By().roughnessX, sums[kOwn], "roughnessX");
    Comparison::Expect(comparison.By().roughnessY, sums[kOwn + 1], "roughnessY");
    for (size_t k = 0; k < 3; ++k) Comparison::Expect(comparison.By().albedo[k][0], sums[kOwn + 2 + k], "F0");
}

TEST(FlashPhoto, DerivativesOfFlakesAreThoseOfJets) {
    constexpr int kOwn = FirstOwn, kNumJets = kOwn + 12;
    const Surface s = RoughSurface(Reflectance::Flakes);
    const Comparison comparison(s);
    std::array<double, kNumJets> sums{};
    using T = Jet<kNumJets>;
    const auto alpha2 = [](const T& r) { return T(r * r * r * r); };
    const T topF0(s.topF0, kOwn), topRough(s.topRoughness, kOwn + 1), flakeRough(s.flakeRoughness, kOwn + 2);
    const T weight(s.glowWeight, kOwn + 3), glowF0(s.glowF0, kOwn + 4), glowRough(s.glowRoughness, kOwn + 5);
    for (size_t i = 0; i < kPoints; ++i) {
        const JetPixel<kNumJets> pixel(s, i);
        const T flat = CosineAt(pixel.at, T(0.), T(0.)), c = CosineAt(pixel.at, pixel.slopeX, pixel.slopeY);
        const T top = topF0 * BackLobe(Brdf::Smith, flat, alpha2(topRough));
        const T glow = weight * glowF0 * BackLobe(Brdf::Smith, flat, alpha2(glowRough));
        const T flake = BackLobe(Brdf::Smith, c, alpha2(flakeRough));
        T sum(0.);
        for (size_t k = 0; k < 3; ++k)
            sum += comparison.Weight(i, k) * pixel.irradiance *
                   (T(s.albedo[k][0], kOwn + 6 + int(k)) * flat / std::numbers::pi + top + glow +
                    T(s.flakeF0[k], kOwn + 9 + int(k)) * flake);
        for (size_t p = 0; p < sums.size(); ++p) sums[p] += sum.v[int(p)];
        Comparison::Expect(comparison.By().slopeX[i], sum.v[SlopeX], "slopeX");
        Comparison::Expect(comparison.By().slopeY[i], sum.v[SlopeY], "slopeY");
    }
    comparison.ExpectSettings({sums[0], sums[1], sums[2], sums[3]});
    const Surface& by = comparison.By();
    const double own[] = {by.topF0,        by.topRoughness,  by.flakeRoughness, by.glowWeight,
                          by.glowF0,       by.glowRoughness, by.albedo[0][0],   by.albedo[1][0],
                          by.albedo[2][0], by.flakeF0[0],    by.flakeF0[1],     by.flakeF0[2]};
    for (size_t p = 0; p < std::size(own); ++p) Comparison::Expect(own[p], sums[kOwn + p], "of flakes");
}

// A flat mirror-like surface under the axis: f = F0 D / 4 with D = 1 / (pi alpha^2), and rho / pi beside it.
TEST(FlashPhoto, CentreOfAFlatSurfaceHasItsClosedForm) {
    const MapGrid tiny{2, 1e-6, false};
    Surface s;
    s.slopeX = s.slopeY = Field(4, 0.);
    s.albedo = {Field{0.5}, Field{0.25}, Field{0.}};
    s.roughness = {0.3};
    PlanarImage linear;
    for (const Brdf brdf : {Brdf::Smith, Brdf::Chapter}) {
        FlashPhoto(tiny, 20, brdf).Forward(s, {400, 10, 0, 0}, &linear);
        const double lobe = 0.04 / (4 * std::numbers::pi * std::pow(0.3, 4));
        EXPECT_NEAR(linear.Channel(0)[0], 0.5 / std::numbers::pi + lobe, 1e-10);
        EXPECT_NEAR(linear.Channel(2)[0], lobe, 1e-10);
    }
    // Isotropic metal is the same lobe.
    s.reflectance = Reflectance::Metal;
    s.roughnessX = s.roughnessY = 0.3;
    FlashPhoto(tiny, 20, Brdf::Smith).Forward(s, {400, 10, 0, 0}, &linear);
    EXPECT_NEAR(linear.Channel(0)[0], 0.5 / (4 * std::numbers::pi * std::pow(0.3, 4)), 1e-10);
}

// Away from the axis an isotropic metal and the lobe of a dielectric agree as well, whatever the slopes.
TEST(FlashPhoto, IsotropicMetalIsTheLobeOfADielectric) {
    Surface metal = RoughSurface(Reflectance::Metal), dielectric = metal;
    metal.roughnessX = metal.roughnessY = 0.5;
    dielectric.reflectance = Reflectance::Dielectric;
    dielectric.roughness = {0.5};
    for (size_t k = 0; k < 3; ++k) {
        metal.albedo[k] = {kDielectricF0};
        dielectric.albedo[k] = {0.};
    }
    const FlashPhoto photo(kGrid, kDistance, Brdf::Smith);
    PlanarImage a, b;
    photo.Forward(metal, kSettings, &a);
    photo.Forward(dielectric, kSettings, &b);
    for (size_t i = 0; i < a.values.size(); ++i) EXPECT_NEAR(a.values[i], b.values[i], 1e-12 * b.values[i]);
}

// The derivatives of tone curves, from 0 to beyond 1, where they are clamped.
TEST(ToneCurve, DerivativesAreThoseOfDifferences) {
    for (const ToneCurve curve : {ToneCurve::SRGB, ToneCurve::Gamma22, ToneCurve::Linear}) {
        PlanarImage linear(16), toned, by(16);
        linear.values = RandomNumbers(3 * 256, 4, 1e-3, 1.3);
        linear.values[7] = -0.2;
        ApplyTone(curve, linear, &toned);
        std::fill(by.values.begin(), by.values.end(), 1.);
        ToneAdjoint(curve, linear, toned, &by);
        for (size_t i = 0; i < linear.values.size(); ++i) {
            const double step = 1e-5 * std::abs(linear.values[i]);
            const double difference = DifferenceAlong(
                [&](double t) {
                    PlanarImage moved(1), out;
                    moved.values.assign(3, linear.values[i] + t);
                    ApplyTone(curve, moved, &out);
                    return out.values[0];
                },
                step);
            // Two values in a thousand are so near to a joint that a difference steps over it.
            if (std::abs(linear.values[i] - 1) < 1e-4 || std::abs(linear.values[i] - 0.0031308) < 1e-6)
                continue;
            EXPECT_NEAR(by.values[i], difference, 1e-8 * (1 + difference)) << linear.values[i];
        }
        EXPECT_EQ(by.values[7], 0);
    }
}

TEST(ToneCurve, AgreesWithItsStandard) {
    PlanarImage linear(1), toned;
    linear.values = {0.0031308 / 2, 0.5, 0.214};
    ApplyTone(ToneCurve::SRGB, linear, &toned);
    EXPECT_NEAR(toned.values[0], 12.92 * 0.0031308 / 2, 1e-15);
    EXPECT_NEAR(toned.values[1], 1.055 * std::pow(0.5, 1 / 2.4) - 0.055, 1e-14);
    ApplyTone(ToneCurve::Gamma22, linear, &toned);
    EXPECT_NEAR(toned.values[2], std::pow(0.214, 1 / 2.2), 1e-14);
    linear.values = {2, 0.5, 1};
    EXPECT_NEAR(ClippedShare(linear), 2. / 3, 1e-15);
}

}  // namespace
}  // namespace lacquer::estimate::flash_photo_test
