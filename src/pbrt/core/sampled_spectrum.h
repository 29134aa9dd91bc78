// Values at the few wavelengths that one path carries.
#pragma once

#include <bit>
#include <utility>

#include "pbrt/core/math.h"

namespace lacquer {

/// Wavelengths a path carries; one SIMD register of floats where the machine has AVX, else two.
inline constexpr int kNumWavelengths = 8;
static_assert(std::has_single_bit(unsigned(kNumWavelengths)) && kNumWavelengths >= 4, "spectra are halved");

/// f(0), f(1), ... in the elements of a vector, of floats or of what else f gives.
template <class Vector, class Function>
[[gnu::always_inline]] inline Vector MakeLanes(const Function& f) {
    const auto make = [&]<int... lane>(std::integer_sequence<int, lane...>) { return Vector{f(lane)...}; };
    return make(std::make_integer_sequence<int, kNumWavelengths>{});
}

/// All elements of a vector in one, by halves: combine(combine(x0, x1), combine(x2, x3)) of four.
/// @param combine  of two floats or of two vectors of them, element by element
template <int count = kNumWavelengths, class Vector, class Function>
[[gnu::always_inline]] inline auto ReduceLanes(Vector v, const Function& combine) {
    if constexpr (count == 4) {
        return combine(combine(v[0], v[1]), combine(v[2], v[3]));
    } else {
        const auto combineHalves = [&]<int... lane>(std::integer_sequence<int, lane...>) {
            return combine(__builtin_shufflevector(v, v, lane...),
                           __builtin_shufflevector(v, v, (lane + count / 2)...));
        };
        return ReduceLanes<count / 2>(combineHalves(std::make_integer_sequence<int, count / 2>{}), combine);
    }
}

/// A spectral quantity at the path's wavelengths. Arithmetic is element by element.
class alignas(4 * kNumWavelengths) SampledSpectrum {  // with and without AVX
  public:
    using Lanes = float __attribute__((vector_size(4 * kNumWavelengths)));

    SampledSpectrum() : v_{} {}
    explicit SampledSpectrum(float c) : v_(MakeLanes<Lanes>([c](int) { return c; })) {}
    SampledSpectrum(Lanes v) : v_(v) {}  // NOLINT: a vector of lanes is a spectrum

    float operator[](int i) const { return v_[i]; }
    void Set(int i, float x) { v_[i] = x; }
    Lanes Raw() const { return v_; }

    SampledSpectrum operator+(SampledSpectrum b) const { return v_ + b.v_; }
    SampledSpectrum operator-(SampledSpectrum b) const { return v_ - b.v_; }
    SampledSpectrum operator*(SampledSpectrum b) const { return v_ * b.v_; }
    SampledSpectrum operator/(SampledSpectrum b) const { return v_ / b.v_; }
    SampledSpectrum operator*(float b) const { return v_ * b; }
    SampledSpectrum operator/(float b) const { return v_ * (1 / b); }
    SampledSpectrum operator-() const { return -v_; }
    friend SampledSpectrum operator*(float a, SampledSpectrum b) { return b * a; }
    friend SampledSpectrum operator-(float a, SampledSpectrum b) { return SampledSpectrum(a) - b; }
    friend SampledSpectrum operator+(float a, SampledSpectrum b) { return SampledSpectrum(a) + b; }
    SampledSpectrum& operator+=(SampledSpectrum b) {
        v_ += b.v_;
        return *this;
    }
    SampledSpectrum& operator-=(SampledSpectrum b) {
        v_ -= b.v_;
        return *this;
    }
    SampledSpectrum& operator*=(SampledSpectrum b) {
        v_ *= b.v_;
        return *this;
    }
    SampledSpectrum& operator*=(float b) {
        v_ *= b;
        return *this;
    }
    SampledSpectrum& operator/=(float b) {
        v_ *= 1 / b;
        return *this;
    }
    bool operator==(SampledSpectrum b) const { return IsEverywhere(v_ == b.v_); }

    float MaxComponent() const {
        return ReduceLanes(v_, [](auto a, auto b) { return a < b ? b : a; });
    }
    float MinComponent() const {
        return ReduceLanes(v_, [](auto a, auto b) { return b < a ? b : a; });
    }
    float Sum() const {
        return ReduceLanes(v_, [](auto a, auto b) { return a + b; });
    }
    float Average() const { return Sum() * (1.f / kNumWavelengths); }
    /// False where every element is zero; NaN counts as non-zero.
    explicit operator bool() const { return !IsEverywhere(v_ == Lanes{}); }
    /// True if every element is finite and not negative: what a radiance must be.
    bool IsValid() const { return IsEverywhere((v_ >= 0.f) & (v_ <= std::numeric_limits<float>::max())); }

  private:
    using Mask = decltype(Lanes{} == Lanes{});  ///< -1 where something is so, else 0
    static bool IsEverywhere(Mask mask) {
        return ReduceLanes(mask, [](auto a, auto b) { return a & b; });
    }

    Lanes v_;
};

/// f of each element.
template <class Function>
SampledSpectrum Map(SampledSpectrum s, const Function& f) {
    return MakeLanes<SampledSpectrum::Lanes>([&](int i) { return f(s[i]); });
}
inline SampledSpectrum Min(SampledSpectrum a, SampledSpectrum b) {
    return a.Raw() < b.Raw() ? a.Raw() : b.Raw();
}
inline SampledSpectrum Max(SampledSpectrum a, SampledSpectrum b) {
    return a.Raw() > b.Raw() ? a.Raw() : b.Raw();
}
inline SampledSpectrum Clamp(SampledSpectrum s, float low, float high) {
    return Min(Max(s, SampledSpectrum(low)), SampledSpectrum(high));
}
inline SampledSpectrum Sqrt(SampledSpectrum s) {
    return Map(s, [](float x) { return std::sqrt(x); });
}
inline SampledSpectrum SafeSqrt(SampledSpectrum s) { return Sqrt(Max(s, SampledSpectrum(0))); }
/// Exp(float) of each element, step by step for all at once: one after the other takes three times as long.
inline SampledSpectrum Exp(SampledSpectrum s) {
    using Floats = SampledSpectrum::Lanes;
    using Integers = int32_t __attribute__((vector_size(4 * kNumWavelengths)));
    const Floats x = s.Raw(), lowest = Floats{} - 87.f, highest = Floats{} + 88.f;
    const Floats above = x < lowest ? lowest : x, inside = highest < above ? highest : above;
    const Floats rounded = inside * 1.44269504f + 0x1.8p23f, n = rounded - 0x1.8p23f;
    const Floats r = n * 2.12194440e-4f + (n * -0.693359375f + inside);
    Floats p = r * 1.4473970e-3f + 8.3704448e-3f;
    p = r * p + 4.1656992e-2f;
    p = r * p + 0.16666493f;
    p = r * p + 0.50000038f;
    p = r * p + 1.f;
    p = r * p + 1.f;
    const Integers bits = std::bit_cast<Integers>(p) + (std::bit_cast<Integers>(rounded) << 23);
    return x < lowest ? Floats{} : std::bit_cast<Floats>(bits);
}
inline SampledSpectrum Lerp(float t, SampledSpectrum a, SampledSpectrum b) { return a * (1 - t) + b * t; }
/// a/b, 0 where b is 0.
inline SampledSpectrum SafeDivide(SampledSpectrum a, SampledSpectrum b) {
    const SampledSpectrum::Lanes zero{};
    return b.Raw() != zero ? a.Raw() / b.Raw() : zero;
}

/// Range of the wavelengths that are rendered [nm].
inline constexpr float kLambdaMin = 360, kLambdaMax = 830;

/// The wavelengths of one path [nm] and the densities with which they were drawn [1/nm].
class SampledWavelengths {
  public:
    SampledWavelengths() = default;
    /// Density 0.0039398042 / cosh^2(0.0072 (lambda - 538)) on [360, 830] nm, which follows the eye's
    /// response; stratified over the lanes by rotating u in [0,1).
    static SampledWavelengths SampleVisible(float u);
    /// Equal density on [low, high], stratified likewise.
    static SampledWavelengths SampleUniform(float u, float low = kLambdaMin, float high = kLambdaMax);
    /// Wavelengths that were chosen and not drawn: the densities are 1.
    static SampledWavelengths At(SampledSpectrum lambda) {
        SampledWavelengths chosen;
        chosen.lambda_ = lambda;
        chosen.pdf_ = SampledSpectrum(1);
        return chosen;
    }

    float operator[](int i) const { return lambda_[i]; }
    SampledSpectrum Lambda() const { return lambda_; }
    SampledSpectrum Pdf() const { return pdf_; }
    /// A dispersive event follows the first wavelength only: the others get density 0, and the first one
    /// stands for all (its density is divided by their number). The others become equal to it, so that what
    /// is drawn by one of them is drawn by it. Does nothing the second time.
    void TerminateSecondary();
    bool SecondaryTerminated() const { return pdf_[1] == 0; }  // no density is 0 before

  private:
    SampledSpectrum lambda_, pdf_;
};

// The visible-wavelength warp as a set.
float SampleVisibleWavelength(float u);
float PdfVisibleWavelength(float lambda);
float InvertVisibleWavelength(float lambda);

}  // namespace lacquer
