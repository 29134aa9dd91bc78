// Spectra as functions of wavelength.
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pbrt/core/sampled_spectrum.h"

namespace lacquer {

/// A function of wavelength, immutable, shared between threads.
class Spectrum {
  public:
    virtual ~Spectrum() = default;
    /// Value at `lambda` [nm].
    virtual float Evaluate(float lambda) const = 0;
    /// Values at a path's wavelengths.
    virtual SampledSpectrum Sample(const SampledWavelengths& lambda) const;
    /// Largest value (an upper bound is enough).
    virtual float MaxValue() const = 0;
    /// True if the value is the same at all wavelengths (an index like that does not disperse).
    virtual bool IsConstant() const { return false; }
};

class ConstantSpectrum final : public Spectrum {
  public:
    explicit ConstantSpectrum(float value) : value_(value) {}
    float Evaluate(float) const override { return value_; }
    SampledSpectrum Sample(const SampledWavelengths&) const override { return SampledSpectrum(value_); }
    float MaxValue() const override { return value_; }
    bool IsConstant() const override { return true; }

  private:
    float value_;
};

/// Linear between given samples, zero outside of them.
class PiecewiseLinearSpectrum final : public Spectrum {
  public:
    /// @param lambda  strictly increasing [nm]    @param values  as many
    PiecewiseLinearSpectrum(std::vector<float> lambda, std::vector<float> values);
    /// The same with the ends continued as constants to 359 and 831 nm, as the built-in tables are.
    static PiecewiseLinearSpectrum Extended(std::vector<float> lambda, std::vector<float> values);
    float Evaluate(float lambda) const override {
        // Mostly one access to memory: what metals are made of is asked for at every hit.
        if (cells_.empty() || !(lambda >= kLambdaMin && lambda < kLambdaMax))
            return Between(0, lambda_.size(), lambda);
        const float first = std::floor(lambda);
        const Cell* const cell = &cells_[size_t(first - kLambdaMin)];
        if (cell->isLinear) return cell->value + (lambda - first) * cell->slope;
        return Between(cell->interval, cell[1].interval + 2, lambda);
    }
    SampledSpectrum Sample(const SampledWavelengths& lambda) const override {
        return Map(lambda.Lambda(), [this](float nm) { return Evaluate(nm); });
    }
    float MaxValue() const override { return max_; }
    void Scale(float s);

  private:
    /// The function from one whole nanometre to the next.
    struct Cell {
        float value = 0, slope = 0;
        uint32_t interval = 0;  ///< of samples, in which it begins
        bool isLinear = false;  ///< no sample is inside, and no end
    };
    /// By a search among the samples from `first` to before `end`.
    float Between(size_t first, size_t end, float lambda) const;

    std::vector<float> lambda_, values_;
    std::vector<Cell> cells_;  ///< from kLambdaMin to kLambdaMax, and one more for its interval
    float max_ = 0;
};

/// Planck's law at a temperature, divided by its own maximum.
class BlackbodySpectrum final : public Spectrum {
  public:
    explicit BlackbodySpectrum(float kelvin);
    float Evaluate(float lambda) const override;
    float MaxValue() const override { return 1; }

  private:
    float kelvin_, normalization_;
};

/// Spectral radiance of a black body [W sr^-1 m^-3] at `lambda` [nm], `kelvin` > 0.
float BlackbodyRadiance(float lambda, float kelvin);

/// One value per integer nanometre, looked up at the nearest one, zero outside [360, 830].
class DenselySampledSpectrum final : public Spectrum {
  public:
    static constexpr int kFirst = 360, kCount = 471;
    explicit DenselySampledSpectrum(const std::function<float(float)>& f);
    explicit DenselySampledSpectrum(const Spectrum& s)
        : DenselySampledSpectrum([&](float lambda) { return s.Evaluate(lambda); }) {}
    float Evaluate(float lambda) const override {
        const int i = int(lambda + 0.5f) - kFirst;
        return i >= 0 && i < kCount ? values_[size_t(i)] : 0.f;
    }
    SampledSpectrum Sample(const SampledWavelengths& lambda) const override {
        return Map(lambda.Lambda(), [this](float nm) { return Evaluate(nm); });
    }
    float MaxValue() const override;
    void Scale(float s);
    std::span<const float> Values() const { return values_; }

  private:
    std::vector<float> values_;
};

/// sum over integer nm 360..830 of a(lambda) b(lambda): the integral that all photometry here uses.
float InnerProduct(const Spectrum& a, const Spectrum& b);

/// A built-in spectrum by its pbrt name (glass-BK7, metal-Cu-k, stdillum-D65, cie-y, ...), or null.
/// Illuminants are rescaled to a luminous integral of kCieYIntegral.
std::unique_ptr<Spectrum> NamedSpectrum(std::string_view name);
/// Names that NamedSpectrum knows.
std::vector<std::string> NamedSpectra();

/// Spectrum from a text file of "wavelength value" pairs, '#' starts a comment.
/// Errors: FileError if it cannot be read, SceneError with line and column for what is not such a file.
std::unique_ptr<Spectrum> ReadSpectrumFile(const std::string& path);

/// Integral of the CIE 1931 luminous efficiency over 360..830 nm.
inline constexpr float kCieYIntegral = 106.856895f;
/// CIE 1931 2-degree colour matching functions.
const DenselySampledSpectrum& CieX();
const DenselySampledSpectrum& CieY();
const DenselySampledSpectrum& CieZ();

}  // namespace lacquer
