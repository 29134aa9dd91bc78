#include "pbrt/scattering/thin_film.h"

#include <numbers>
#include <type_traits>
#include <utility>

#include "pbrt/core/special_functions.h"

namespace lacquer {

namespace {

// Phases need more digits than floats have: a film of a hundred wavelengths turns by a hundred times 2 pi.
// What follows from them does not, but for grazing light and extreme indices.
using Doubles = double __attribute__((vector_size(8 * kNumWavelengths)));
using Floats = SampledSpectrum::Lanes;

template <class V>
using ScalarOf = std::remove_cvref_t<decltype(std::declval<V>()[0])>;

inline Doubles Splat(double x) { return Doubles{} + x; }
inline Doubles ToDoubles(SampledSpectrum s) { return __builtin_convertvector(s.Raw(), Doubles); }
inline SampledSpectrum ToFloats(Doubles x) { return SampledSpectrum(__builtin_convertvector(x, Floats)); }
inline SampledSpectrum ToFloats(Floats x) { return x; }
template <class V>
V Root(V x) {
    return V{std::sqrt(x[0]), std::sqrt(x[1]), std::sqrt(x[2]), std::sqrt(x[3])};
}

/// Rays are kept from the surface itself, along which nothing would move.
constexpr double kMinCosine = 1e-8;

/// Complex numbers, one for each wavelength.
template <class V>
struct ComplexOf {
    V re{}, im{};
    ComplexOf operator+(const ComplexOf& b) const { return {re + b.re, im + b.im}; }
    ComplexOf operator-(const ComplexOf& b) const { return {re - b.re, im - b.im}; }
    ComplexOf operator*(const ComplexOf& b) const { return {re * b.re - im * b.im, re * b.im + im * b.re}; }
    ComplexOf operator*(ScalarOf<V> b) const { return {re * b, im * b}; }
    V SquaredNorm() const { return re * re + im * im; }
};
using Complex = ComplexOf<Doubles>;
inline ComplexOf<Floats> ToFloats(const Complex& z) { return {ToFloats(z.re).Raw(), ToFloats(z.im).Raw()}; }

/// The root in the first quadrant of a number in the upper half plane.
[[gnu::always_inline]] inline Complex Root(const Complex& z) {
    const Doubles norm = Root(z.SquaredNorm());
    // The larger part first; the other one follows without cancellation.
    const Doubles larger = Root(0.5 * (norm + (z.re > 0.0 ? z.re : -z.re)));
    const Doubles other = larger > 0.0 ? 0.5 * z.im / larger : Doubles{};
    return {z.re > 0.0 ? larger : other, z.re > 0.0 ? other : larger};
}

/// One of the three media: its squared index, and the component of its wave vector along the normal, in units
/// of the wave number of the vacuum.
template <class V>
struct WaveOf {
    ComplexOf<V> index2, normal;
};
using Wave = WaveOf<Doubles>;
inline WaveOf<Floats> ToFloats(const Wave& w) { return {ToFloats(w.index2), ToFloats(w.normal)}; }
/// @param s2  squared component along the surface, which is the same in all media
inline Wave WaveIn(const Complex& index, double s2) {
    const Complex index2 = index * index;
    return {index2, Root({index2.re - s2, index2.im})};
}

/// In a medium of a real index. @param normal2  negative where no wave travels
inline Wave RealWave(double index2, double normal2) {
    const Doubles normal = Splat(std::sqrt(std::abs(normal2)));
    return {{Splat(index2)}, normal2 > 0 ? Complex{normal} : Complex{Doubles{}, normal}};
}

/// Amplitudes at a boundary, up to a common factor: reflected is difference over sum.
template <class V>
struct Boundary {
    ComplexOf<V> difference, sum, incident;
};
template <class V>
[[gnu::always_inline]] inline Boundary<V> Perpendicular(const WaveOf<V>& from, const WaveOf<V>& to) {
    return {from.normal - to.normal, from.normal + to.normal, from.normal};
}
template <class V>
[[gnu::always_inline]] inline Boundary<V> Parallel(const WaveOf<V>& from, const WaveOf<V>& to) {
    const ComplexOf<V> a = to.index2 * from.normal, b = from.index2 * to.normal;
    return {a - b, a + b, a};
}

/// Cosine and sine of what a passage to the bottom of the film and back adds to the phase.
struct Phases {
    SampledSpectrum cos, sin;
};
inline Phases PhasesOf(const Doubles& normal, double thickness, const Doubles& lambda) {
    const Doubles turns = 2 * thickness / lambda * normal;
    // Whole turns are left out: this constant leaves no digits behind the point.
    constexpr double kRounder = 0x1.8p52;
    const SampledSpectrum parts = ToFloats(turns - ((turns + kRounder) - kRounder));
    float cosines[kNumWavelengths], sines[kNumWavelengths];
    for (int i = 0; i < kNumWavelengths; ++i) {
        const SinCos phase = SinCosOfTurn(parts[i]);
        cosines[i] = phase.cos;
        sines[i] = phase.sin;
    }
    return {Floats{cosines[0], cosines[1], cosines[2], cosines[3]},
            Floats{sines[0], sines[1], sines[2], sines[3]}};
}
/// exp(2 i beta): what that passage does to a wave; and its absolute value.
template <class V>
struct RoundTrip {
    ComplexOf<V> factor;
    V left;
};
inline RoundTrip<Floats> RoundTripThrough(const Complex& normal, double thickness, const Doubles& lambda) {
    const Phases phases = PhasesOf(normal.re, thickness, lambda);
    const SampledSpectrum left = Exp(ToFloats(-4 * std::numbers::pi * thickness / lambda * normal.im));
    return {{(left * phases.cos).Raw(), (left * phases.sin).Raw()}, left.Raw()};
}
inline RoundTrip<Doubles> ToDoubles(const RoundTrip<Floats>& t) {
    return {{ToDoubles(t.factor.re), ToDoubles(t.factor.im)}, ToDoubles(t.left)};
}

/// Squared norms of Airy's amplitudes of one polarisation, of which the transmitted one lacks the factor
/// between the media.
template <class V>
struct Airy {
    V reflected, transmitted;
};
template <class V>
[[gnu::always_inline]] inline Airy<V> SumOf(const Boundary<V>& top, const Boundary<V>& bottom,
                                            const RoundTrip<V>& trip) {
    // r = (r1 + r2 e) / (1 + r1 r2 e), with the denominators of r1 and r2 multiplied out.
    const ComplexOf<V> direct = top.difference * bottom.sum;
    const ComplexOf<V> through = top.sum * bottom.difference * trip.factor;
    const ComplexOf<V> all = top.sum * bottom.sum + top.difference * bottom.difference * trip.factor;
    const V norm = all.SquaredNorm(), one = V{} + ScalarOf<V>(1);
    const V scale = norm > V{} ? one / norm : V{};
    // Grazing the surface, where everything vanishes, all is reflected.
    const V reflected = norm > V{} ? (direct + through).SquaredNorm() * scale : one;
    const V passed = top.incident.SquaredNorm() * bottom.incident.SquaredNorm();
    return {reflected, ScalarOf<V>(16) * passed * trip.left * scale};
}

template <class V>
SampledSpectrum MeanOf(V a, V b) {
    return Clamp(ToFloats(ScalarOf<V>(0.5) * (a + b)), 0, 1);
}

/// The film between media with real indices, the light on the side of `above`.
template <class V>
ThinFilm::Shares Between(const WaveOf<V>& above, const WaveOf<V>& film, const WaveOf<V>& below,
                         const RoundTrip<V>& trip) {
    const Airy<V> s = SumOf(Perpendicular(above, film), Perpendicular(film, below), trip);
    const Airy<V> p = SumOf(Parallel(above, film), Parallel(film, below), trip);
    const V across = below.normal.re / above.normal.re;
    const V acrossParallel = across * above.index2.re / below.index2.re;
    ThinFilm::Shares shares;
    shares.reflected = MeanOf<V>(s.reflected, p.reflected);
    shares.transmitted =
        Min(MeanOf<V>(s.transmitted * across, p.transmitted * acrossParallel), 1 - shares.reflected);
    return shares;
}
/// The film on metal.
template <class V>
SampledSpectrum ReflectedOn(const WaveOf<V>& above, const WaveOf<V>& film, const WaveOf<V>& metal,
                            const RoundTrip<V>& trip) {
    return MeanOf<V>(SumOf(Perpendicular(above, film), Perpendicular(film, metal), trip).reflected,
                     SumOf(Parallel(above, film), Parallel(film, metal), trip).reflected);
}

// ---- Clear films, which are most: all amplitudes but those of a metal are real, and floats suffice but for
// ---- the phase

/// Light of one polarisation that a clear film on a dielectric lets through. @param a, f, g, b  amplitudes:
/// above and in the film at the upper boundary, in the film and below at the lower one
inline SampledSpectrum PassedPart(SampledSpectrum a, SampledSpectrum f, SampledSpectrum g, SampledSpectrum b,
                                  SampledSpectrum cosine) {
    const SampledSpectrum sums = (a + f) * (g + b), differences = (a - f) * (g - b);
    return 16 * (a * f) * (g * b) /
           (sums * sums + differences * differences + 2 * sums * differences * cosine);
}

/// The same of what it lets into a metal, whose boundary has the complex amplitudes u in the film and v.
inline SampledSpectrum AbsorbedPart(SampledSpectrum a, SampledSpectrum f, SampledSpectrum uRe,
                                    SampledSpectrum uIm, SampledSpectrum vRe, SampledSpectrum vIm,
                                    const Phases& phases) {
    const SampledSpectrum sum = a + f, difference = a - f, re = uRe - vRe, im = uIm - vIm;
    // Amplitudes are added before they are squared, where grazing light would leave few digits.
    const SampledSpectrum allRe = sum * (uRe + vRe) + difference * (re * phases.cos - im * phases.sin);
    const SampledSpectrum allIm = sum * (uIm + vIm) + difference * (re * phases.sin + im * phases.cos);
    return 16 * (a * f) * (uRe * vRe + uIm * vIm) / (allRe * allRe + allIm * allIm);
}

/// A medium that absorbs nothing: its squared index and normal component, both real.
struct ClearWave {
    SampledSpectrum index2, normal;
};
/// Light that passes between media in which waves travel.
SampledSpectrum PassedByClear(const ClearWave& above, const ClearWave& film, const ClearWave& below,
                              SampledSpectrum cosine) {
    const SampledSpectrum perpendicular =
        PassedPart(above.normal, film.normal, film.normal, below.normal, cosine);
    const SampledSpectrum parallel =
        PassedPart(film.index2 * above.normal, above.index2 * film.normal, below.index2 * film.normal,
                   film.index2 * below.normal, cosine);
    return Clamp(0.5f * (perpendicular + parallel), 0, 1);
}
/// Light that metal of the complex index n + i kappa keeps under a clear film.
SampledSpectrum AbsorbedUnderClear(const ClearWave& above, const ClearWave& film, SampledSpectrum n,
                                   SampledSpectrum kappa, float s2, const Phases& phases) {
    const SampledSpectrum re = n * n - kappa * kappa, im = 2 * n * kappa, rest = re - SampledSpectrum(s2);
    // As Root(), which is for doubles.
    const SampledSpectrum norm = Sqrt(rest * rest + im * im);
    const SampledSpectrum larger = Sqrt(0.5f * (norm + Max(rest, -rest)));
    const SampledSpectrum other = SafeDivide(0.5f * im, larger);
    const SampledSpectrum qRe = rest.Raw() > 0.f ? larger.Raw() : other.Raw();
    const SampledSpectrum qIm = rest.Raw() > 0.f ? other.Raw() : larger.Raw();
    const SampledSpectrum perpendicular =
        AbsorbedPart(above.normal, film.normal, film.normal, SampledSpectrum(0), qRe, qIm, phases);
    const SampledSpectrum parallel =
        AbsorbedPart(film.index2 * above.normal, above.index2 * film.normal, re * film.normal,
                     im * film.normal, film.index2 * qRe, film.index2 * qIm, phases);
    return Clamp(0.5f * (perpendicular + parallel), 0, 1);
}

/// Below this cosine, resonances of films on metals and of films that absorb are too sharp for floats.
constexpr double kMinFloatCosine = 0.05;
/// Beyond these, products of indices might leave the range of floats.
constexpr double kMaxFloatIndex = 1e3;
constexpr double kMaxFloatK = 100;
inline bool IsModerate(double index2) {
    return index2 <= Sqr(kMaxFloatIndex) && index2 >= 1 / Sqr(kMaxFloatIndex);
}
inline bool AllPositive(const Doubles& x) { return x[0] > 0 && x[1] > 0 && x[2] > 0 && x[3] > 0; }
inline ClearWave ClearWaveOf(double index2, double normal2) {
    return {SampledSpectrum(float(index2)), SampledSpectrum(float(std::sqrt(normal2)))};
}

}  // namespace

ThinFilm::Shares ThinFilm::OnDielectric(float cosTheta_i, float eta) const {
    // Squared indices relative to the vacuum, what Snell's law keeps, and the squared normal components.
    const bool isFromBelow = cosTheta_i < 0;
    const double index2Above = Sqr(double(etaAbove_)), index2Below = index2Above * Sqr(double(eta));
    const double c = std::clamp(double(std::abs(cosTheta_i)), kMinCosine, 1.0);
    const double s2 = (isFromBelow ? index2Below : index2Above) * (1 - c) * (1 + c);
    const double above2 = isFromBelow ? index2Above - s2 : index2Above * c * c;
    const double below2 = isFromBelow ? index2Below * c * c : index2Below - s2;
    const bool passes = above2 > 0 && below2 > 0;
    if (!passes && !absorbs_) return {SampledSpectrum(1), SampledSpectrum(0)};

    const Doubles filmEta = ToDoubles(eta_), film2 = filmEta * filmEta - s2;
    const bool isModerate = IsModerate(index2Above) && IsModerate(index2Below);
    if (passes && !absorbs_ && isModerate && AllPositive(film2)) {
        const Doubles normal = Root(film2);
        const SampledSpectrum transmitted = PassedByClear(
            ClearWaveOf(index2Above, above2), {eta_ * eta_, ToFloats(normal)},
            ClearWaveOf(index2Below, below2), PhasesOf(normal, double(thickness_), ToDoubles(lambda_)).cos);
        return {1 - transmitted, transmitted};
    }
    const Wave above = RealWave(index2Above, above2), below = RealWave(index2Below, below2);
    const Wave film = WaveIn({filmEta, ToDoubles(k_)}, s2);
    const RoundTrip<Floats> trip = RoundTripThrough(film.normal, double(thickness_), ToDoubles(lambda_));
    const Wave &from = isFromBelow ? below : above, &to = isFromBelow ? above : below;
    if (c >= kMinFloatCosine && isModerate && double(k_.MaxComponent()) <= kMaxFloatK)
        return Between(ToFloats(from), ToFloats(film), ToFloats(to), trip);
    return Between(from, film, to, ToDoubles(trip));
}

SampledSpectrum ThinFilm::OnConductor(float cosTheta_i, SampledSpectrum eta, SampledSpectrum k) const {
    const double indexAbove = double(etaAbove_), index2Above = Sqr(indexAbove);
    const double c = std::clamp(double(cosTheta_i), kMinCosine, 1.0), s2 = index2Above * (1 - c) * (1 + c);
    const Doubles filmEta = ToDoubles(eta_), film2 = filmEta * filmEta - s2;
    const double largest = indexAbove * double(std::max(eta.MaxComponent(), k.MaxComponent()));
    const bool canBeFloat = c >= kMinFloatCosine && IsModerate(index2Above) && largest <= kMaxFloatIndex;
    if (canBeFloat && !absorbs_ && AllPositive(film2)) {
        const Doubles normal = Root(film2);
        return 1 - AbsorbedUnderClear(ClearWaveOf(index2Above, index2Above * c * c),
                                      {eta_ * eta_, ToFloats(normal)}, eta * etaAbove_, k * etaAbove_,
                                      float(s2), PhasesOf(normal, double(thickness_), ToDoubles(lambda_)));
    }
    const Wave above{{Splat(index2Above)}, {Splat(indexAbove * c)}};
    const Wave film = WaveIn({filmEta, ToDoubles(k_)}, s2);
    const Wave metal = WaveIn(Complex{ToDoubles(eta), ToDoubles(k)} * indexAbove, s2);
    const RoundTrip<Floats> trip = RoundTripThrough(film.normal, double(thickness_), ToDoubles(lambda_));
    if (canBeFloat && double(k_.MaxComponent()) <= kMaxFloatK && largest <= kMaxFloatK)
        return ReflectedOn(ToFloats(above), ToFloats(film), ToFloats(metal), trip);
    return ReflectedOn(above, film, metal, ToDoubles(trip));
}

}  // namespace lacquer
