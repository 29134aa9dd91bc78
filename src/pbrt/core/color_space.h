// RGB colour spaces and the smooth spectra that stand for RGB values.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "pbrt/core/spectrum.h"
#include "pbrt/core/vec.h"

namespace lacquer {

/// s(lambda) = 1/2 + x / (2 sqrt(1 + x^2)) with x = c0 lambda^2 + c1 lambda + c2, lambda in nm: a smooth
/// reflectance in (0,1) [Jakob and Hanika 2019].
struct SigmoidPolynomial {
    float c0 = 0, c1 = 0, c2 = 0;
    float Evaluate(float lambda) const {
        const float x = std::fma(lambda, std::fma(lambda, c0, c1), c2);
        if (std::isinf(x)) return x > 0 ? 1.f : 0.f;
        return 0.5f + x / (2 * std::sqrt(1 + x * x));
    }
    SampledSpectrum Sample(const SampledWavelengths& lambda) const {
        if (std::isinf(c2)) return SampledSpectrum(c2 > 0 ? 1.f : 0.f);
        const SampledSpectrum l = lambda.Lambda();
        const SampledSpectrum x = (l * c0 + SampledSpectrum(c1)) * l + SampledSpectrum(c2);
        return SampledSpectrum(0.5f) + x * 0.5f / Sqrt(SampledSpectrum(1) + x * x);
    }
    float MaxValue() const;
};

/// How an RGB value is meant; see pbrt-v4's "spectrum-valued parameters".
enum class SpectrumKind {
    Albedo,      ///< reflectance in [0,1]
    Unbounded,   ///< any non-negative quantity
    Illuminant,  ///< emission: unbounded, times the white of the colour space
};

/// Primaries, white, and the table that turns RGB into spectra. Immutable; there are four of them.
class ColorSpace {
  public:
    /// By its name in a scene file, case ignored; null if unknown.
    static const ColorSpace* Find(std::string_view name);
    static const ColorSpace& SRGB();
    static std::vector<std::string> Names();
    /// The space with these chromaticities {rx, ry, gx, gy, bx, by, wx, wy} within a small tolerance, or
    /// null.
    static const ColorSpace* FromChromaticities(const float chromaticities[8]);

    const std::string& Name() const { return name_; }
    const glm::mat3& XYZFromRGB() const { return xyzFromRgb_; }
    const glm::mat3& RGBFromXYZ() const { return rgbFromXyz_; }
    RGB ToRGB(XYZ xyz) const { return rgbFromXyz_ * xyz; }
    XYZ ToXYZ(RGB rgb) const { return xyzFromRgb_ * rgb; }
    /// The white's spectrum, luminous integral kCieYIntegral.
    const DenselySampledSpectrum& Illuminant() const { return *illuminant_; }
    /// Luminance of an RGB triple, 1 for white.
    float Luminance(RGB rgb) const;
    /// {rx, ry, gx, gy, bx, by, wx, wy}.
    const float* Chromaticities() const { return chromaticities_; }
    Point2 White() const { return {chromaticities_[6], chromaticities_[7]}; }

    /// The polynomial of a colour; components are clamped to [0,1]. Trilinear in a table of 64^3 x 3. O(1).
    SigmoidPolynomial ToPolynomial(RGB rgb) const;
    /// A spectrum for `rgb` used as `kind`. Domain: [0,1] for Albedo, >= 0 otherwise (checked by the caller).
    std::unique_ptr<Spectrum> MakeSpectrum(RGB rgb, SpectrumKind kind) const;

    ColorSpace(const char* name, const float primaries[6], const char* illuminant, const float* table);

  private:
    std::string name_;
    float chromaticities_[8];
    glm::mat3 xyzFromRgb_, rgbFromXyz_;
    std::unique_ptr<DenselySampledSpectrum> illuminant_;
    const float* table_;  // 64 nodes, then [3][64][64][64][3]; see sigmoid_fit.h
};

/// A colour as a spectrum at a path's wavelengths without allocation: what image textures and lights use.
/// Domain and meaning as ColorSpace::MakeSpectrum. Cost: one table look-up.
SampledSpectrum SampleRGB(const ColorSpace& space, RGB rgb, SpectrumKind kind,
                          const SampledWavelengths& lambda);

/// (X, Y, Z) of a spectrum: inner products with the observer, divided by kCieYIntegral.
XYZ SpectrumToXYZ(const Spectrum& s);

/// CIE xy chromaticity; (0,0) for black.
Point2 Chromaticity(XYZ xyz);
/// The tristimulus value with chromaticity xy and luminance Y.
XYZ FromChromaticity(Point2 xy, float Y);
/// Matrix on XYZ that adapts colours seen under white `from` to white `to` (chromaticities), Bradford.
glm::mat3 WhiteBalance(Point2 from, Point2 to);
/// The CIE daylight spectrum of a correlated colour temperature [K]; a blackbody below 4000 K.
/// The temperature is scaled by 1.4388/1.4380 to today's radiation constant, values by 0.01.
std::unique_ptr<DenselySampledSpectrum> DaylightSpectrum(float kelvin);

}  // namespace lacquer
