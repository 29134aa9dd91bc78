#include "pbrt/scattering/thin_film.h"

#include <bit>
#include <type_traits>

#include "pbrt/core/lane_functions.h"

namespace lacquer {

namespace {

// Phases need more digits than floats have: a film of a hundred wavelengths turns by a hundred times 2 pi.
// What follows from them does not, but for grazing light and extreme indices.
using Doubles = double __attribute__((vector_size(8 * kNumWavelengths)));
using Floats = LaneFloats;

inline Doubles Splat(double x) {
    return MakeLanes<Doubles>([x](int) { return x; });
}
inline Floats SplatFloat(float x) { return SampledSpectrum(x).Raw(); }
inline Doubles ToDoubles(Floats s) { return __builtin_convertvector(s, Doubles); }
inline Floats ToFloats(Doubles x) { return __builtin_convertvector(x, Floats); }
template <class V>
V Root(V x) {
    return MakeLanes<V>([&x](int i) { return std::sqrt(x[i]); });
}

/// Rays are kept from the surface itself, along which nothing would move.
constexpr double kMinCosine = 1e-8;

/// Complex numbers, one for each lane of a vector.
template <class V>
struct ComplexOf {
    V re{}, im{};
    ComplexOf operator+(const ComplexOf& b) const { return {re + b.re, im + b.im}; }
    ComplexOf operator-(const ComplexOf& b) const { return {re - b.re, im - b.im}; }
    ComplexOf operator*(const ComplexOf& b) const { return {re * b.re - im * b.im, re * b.im + im * b.re}; }
    ComplexOf operator*(V b) const { return {re * b, im * b}; }
    V SquaredNorm() const { return re * re + im * im; }
};
using Complex = ComplexOf<Doubles>;
using FloatComplex = ComplexOf<Floats>;

/// The root in the first quadrant of a number in the upper half plane. @param norm  of that number
template <class V>
[[gnu::always_inline]] inline ComplexOf<V> RootOfNorm(const ComplexOf<V>& z, V norm) {
    const V zero{}, half = zero + std::remove_cvref_t<decltype(zero[0])>(0.5);
    // The larger part first; the other one follows without cancellation.
    const V larger = Root(half * (norm + (z.re > zero ? z.re : -z.re)));
    const V other = larger > zero ? half * z.im / larger : zero;
    return {z.re > zero ? larger : other, z.re > zero ? other : larger};
}
template <class V>
[[gnu::always_inline]] inline ComplexOf<V> Root(const ComplexOf<V>& z) {
    return RootOfNorm<V>(z, Root(z.SquaredNorm()));
}

/// Cosine and sine of what a passage to the bottom of the film and back adds to the phase.
struct Phases {
    Floats cos, sin;
};
/// exp(2 i beta): what that passage does to a wave; and its absolute value.
template <class V>
struct RoundTrip {
    ComplexOf<V> factor;
    V left;
};
/// @param decay  imaginary part of the phase, in quarters of a turn
inline RoundTrip<Floats> RoundTripOf(const Phases& phases, Floats decay) {
    const Floats left = ExpOfLanes(-PiOver2 * decay);
    return {{left * phases.cos, left * phases.sin}, left};
}

// ---- Numbers of twice as many digits as floats have, for phases: sums of two floats, the second of which is
// ---- what rounding has left [Dekker 1971]. They cost half of what doubles do, which have half as many
// lanes.

struct FloatPair {
    Floats high, low;
};
inline Floats FusedMultiplyAdd(Floats a, Floats b, Floats c) {
    return MakeLanes<Floats>([&](int i) { return std::fma(a[i], b[i], c[i]); });
}
inline FloatPair SplitOf(const Doubles& x) {
    const Floats high = ToFloats(x);
    return {high, ToFloats(x - ToDoubles(high))};
}
inline FloatPair SplitOf(double x) {
    const auto high = float(x);
    return {SplatFloat(high), SplatFloat(float(x - double(high)))};
}
inline FloatPair operator-(const FloatPair& a, const FloatPair& b) {
    const Floats difference = a.high - b.high, taken = a.high - difference;
    const Floats rest = (a.high - (difference + taken)) + (taken - b.high);
    return {difference, rest + (a.low - b.low)};
}
/// Of a phase in quarters of a turn, the product of both; less than 2^22.
inline Phases PhasesOf(const FloatPair& a, const FloatPair& b) {
    // Adding this constant rounds to an integer, which is then in the lower bits.
    constexpr float kRounder = 0x1.8p23f;
    const Floats product = a.high * b.high, rounded = product + kRounder;
    const Floats r = product - (rounded - kRounder);
    const LaneSinCos phase = SinCosOfQuarters(std::bit_cast<LaneInts>(rounded), r);
    // Turned by the rest, whose third power is nothing: so nobody waits for it.
    const Floats rest = FusedMultiplyAdd(a.high, b.high, -product) + (a.low * b.high + a.high * b.low);
    const Floats angle = PiOver2 * rest, cosOfRest = 1.f - 0.5f * angle * angle;
    return {phase.cos * cosOfRest - phase.sin * angle, phase.sin * cosOfRest + phase.cos * angle};
}

// ---- Any media, in double precision ---------------------------------------------------------------------

/// One of the three media: its squared index, and the component of its wave vector along the normal, in units
/// of the wave number of the vacuum.
struct Wave {
    Complex index2, normal;
};
/// @param s2  squared component along the surface, which is the same in all media
inline Wave WaveIn(const Complex& index, double s2) {
    const Complex index2 = index * index;
    return {index2, Root(Complex{index2.re - s2, index2.im})};
}
/// In a medium of a real index. @param normal2  negative where no wave travels
inline Wave RealWave(double index2, double normal2) {
    const Doubles normal = Splat(std::sqrt(std::abs(normal2)));
    return {{Splat(index2)}, normal2 > 0 ? Complex{normal} : Complex{Doubles{}, normal}};
}

/// Amplitudes at a boundary, up to a common factor: reflected is difference over sum.
struct Boundary {
    Complex difference, sum, incident;
};
inline Boundary Perpendicular(const Wave& from, const Wave& to) {
    return {from.normal - to.normal, from.normal + to.normal, from.normal};
}
inline Boundary Parallel(const Wave& from, const Wave& to) {
    const Complex a = to.index2 * from.normal, b = from.index2 * to.normal;
    return {a - b, a + b, a};
}

/// Squared norms of Airy's amplitudes of one polarisation, of which the transmitted one lacks the factor
/// between the media.
struct Airy {
    Doubles reflected, transmitted;
};
inline Airy SumOf(const Boundary& top, const Boundary& bottom, const RoundTrip<Doubles>& trip) {
    // r = (r1 + r2 e) / (1 + r1 r2 e), with the denominators of r1 and r2 multiplied out.
    const Complex direct = top.difference * bottom.sum;
    const Complex through = top.sum * bottom.difference * trip.factor;
    const Complex all = top.sum * bottom.sum + top.difference * bottom.difference * trip.factor;
    const Doubles norm = all.SquaredNorm(), one = Splat(1);
    const Doubles scale = norm > 0.0 ? one / norm : Doubles{};
    // Grazing the surface, where everything vanishes, all is reflected.
    const Doubles reflected = norm > 0.0 ? (direct + through).SquaredNorm() * scale : one;
    const Doubles passed = top.incident.SquaredNorm() * bottom.incident.SquaredNorm();
    return {reflected, 16 * passed * trip.left * scale};
}

inline SampledSpectrum MeanOf(const Doubles& a, const Doubles& b) {
    return Clamp(ToFloats(0.5 * (a + b)), 0, 1);
}

/// The film between media with real indices, the light on the side of `above`.
ThinFilm::Shares Between(const Wave& above, const Wave& film, const Wave& below,
                         const RoundTrip<Doubles>& trip) {
    const Airy s = SumOf(Perpendicular(above, film), Perpendicular(film, below), trip);
    const Airy p = SumOf(Parallel(above, film), Parallel(film, below), trip);
    const Doubles across = below.normal.re / above.normal.re;
    const Doubles acrossParallel = across * above.index2.re / below.index2.re;
    ThinFilm::Shares shares;
    shares.reflected = MeanOf(s.reflected, p.reflected);
    shares.transmitted =
        Min(MeanOf(s.transmitted * across, p.transmitted * acrossParallel), 1 - shares.reflected);
    return shares;
}
/// The film on metal.
SampledSpectrum ReflectedOn(const Wave& above, const Wave& film, const Wave& metal,
                            const RoundTrip<Doubles>& trip) {
    return MeanOf(SumOf(Perpendicular(above, film), Perpendicular(film, metal), trip).reflected,
                  SumOf(Parallel(above, film), Parallel(film, metal), trip).reflected);
}

/// The film, and a passage through it. @param perNormal  quarters of a turn for a normal component of 1
struct DoubleTerms {
    Wave film;
    RoundTrip<Doubles> trip;
};
DoubleTerms DoubleTermsOf(const FloatComplex& index, double s2, const FloatPair& perNormal) {
    const Wave film = WaveIn({ToDoubles(index.re), ToDoubles(index.im)}, s2);
    const Floats decay = perNormal.high * ToFloats(film.normal.im);
    const RoundTrip<Floats> t = RoundTripOf(PhasesOf(perNormal, SplitOf(film.normal.re)), decay);
    return {film, {{ToDoubles(t.factor.re), ToDoubles(t.factor.im)}, ToDoubles(t.left)}};
}

// ---- Films that absorb or in which no wave travels, in floats but for the phase -------------------------

/// 1 over the square of a complex index.
inline FloatComplex InverseSquare(const FloatComplex& index) {
    const FloatComplex index2 = index * index;
    const Floats inverse = 1.f / index.SquaredNorm();
    return {index2.re * inverse * inverse, -index2.im * inverse * inverse};
}

// With the normal component n, or n over the squared index for the parallel polarisation, as a above, f in
// the film and b below, both boundaries are alike, (a - f) / (a + f) and (f - b) / (f + b), and the terms of
// Airy's sum are sums and differences of four products:
//     (a + f) (f + b) = v + u,  (a - f) (f - b) = v - u,  u = ab + f^2,  v = (a + b) f,
//     (a - f) (f + b) = x + w,  (a + f) (f - b) = x - w,  w = ab - f^2,  x = (a - b) f.
// Light that does not graze the surface leaves no sum without a rest: a is not 0, nor is f.

/// What both polarisations see of the film, and what a passage does to a wave.
struct FloatFilm {
    FloatComplex s, s2, p, p2;  ///< f and its square, for the perpendicular and the parallel polarisation
    RoundTrip<Floats> trip;
};
/// @param re  real part of the squared normal component, @param im  its imaginary part, not 0
/// @param inverse2, inverse4   powers of 1 over the index
/// @param perNormal  quarters of a turn for a component of 1
[[gnu::always_inline]] inline FloatFilm FloatFilmOf(const FloatPair& re, Floats im,
                                                    const FloatComplex& inverse2,
                                                    const FloatComplex& inverse4,
                                                    const FloatPair& perNormal) {
    const FloatComplex z{re.high, im};
    const Floats norm = Root(z.SquaredNorm());
    const FloatComplex root = RootOfNorm(z, norm);
    // The root errs by re(d conj(root)) / (2 |root|^2), where d is the error of its square.
    const Floats dRe = FusedMultiplyAdd(root.im, root.im, FusedMultiplyAdd(-root.re, root.re, z.re)) + re.low;
    const Floats dIm = FusedMultiplyAdd(-2.f * root.re, root.im, im);
    const Floats rest = (dRe * root.re + dIm * root.im) * (0.5f / norm);
    return {root, z, root * inverse2, z * inverse4,
            RoundTripOf(PhasesOf(perNormal, {root.re, rest}), perNormal.high * root.im)};
}

/// sum + difference + (sum - difference) trip
inline FloatComplex AirySum(const FloatComplex& sum, const FloatComplex& difference,
                            const FloatComplex& trip) {
    const FloatComplex s = sum + difference, d = sum - difference;
    return {(s.re + d.re * trip.re) - d.im * trip.im, (s.im + d.re * trip.im) + d.im * trip.re};
}
/// Of one polarisation.
struct FloatShares {
    Floats reflected, transmitted;
};
/// Between media in which waves travel. @param f2  the square of f, @param a, b  of the side of the light,
/// and of the other one
inline FloatShares BetweenReal(const FloatFilm& film, float a, const FloatComplex& f, const FloatComplex& f2,
                               float b) {
    const float ab = a * b;
    const FloatComplex all = AirySum(f * SplatFloat(a + b), {ab + f2.re, f2.im}, film.trip.factor);
    const FloatComplex back = AirySum(f * SplatFloat(a - b), {ab - f2.re, -f2.im}, film.trip.factor);
    const Floats scale = 1.f / all.SquaredNorm();
    return {back.SquaredNorm() * scale, 16 * ab * f.SquaredNorm() * film.trip.left * scale};
}
/// Over a medium that lets nothing through, or a metal.
inline Floats ReflectedOver(const FloatFilm& film, float a, const FloatComplex& f, const FloatComplex& f2,
                            const FloatComplex& b) {
    const FloatComplex ab = b * SplatFloat(a);
    const FloatComplex all = AirySum(f * FloatComplex{a + b.re, b.im}, ab + f2, film.trip.factor);
    const FloatComplex back = AirySum(f * FloatComplex{a - b.re, -b.im}, ab - f2, film.trip.factor);
    return back.SquaredNorm() / all.SquaredNorm();
}
inline SampledSpectrum MeanOf(Floats s, Floats p, SampledSpectrum largest = SampledSpectrum(1)) {
    return Min(0.5f * (s + p), largest);
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
/// Light that metal of the complex squared index `metal2` keeps under a clear film. @param q  its normal
/// component
SampledSpectrum AbsorbedUnderClear(const ClearWave& above, const ClearWave& film, const FloatComplex& metal2,
                                   const FloatComplex& q, const Phases& phases) {
    const SampledSpectrum qRe = q.re, qIm = q.im;
    const SampledSpectrum perpendicular =
        AbsorbedPart(above.normal, film.normal, film.normal, SampledSpectrum(0), qRe, qIm, phases);
    const SampledSpectrum parallel =
        AbsorbedPart(film.index2 * above.normal, above.index2 * film.normal, film.normal * metal2.re,
                     film.normal * metal2.im, film.index2 * qRe, film.index2 * qIm, phases);
    return Clamp(0.5f * (perpendicular + parallel), 0, 1);
}

/// What is seen of the film where nothing absorbs. @param square  of the normal component, positive
struct ClearFilm {
    Floats normal;
    Phases phases;
};
inline ClearFilm ClearFilmOf(const FloatPair& square, const FloatPair& perNormal) {
    const Floats root = Root(square.high);
    const Floats error = FusedMultiplyAdd(-root, root, square.high) + square.low;
    return {root, PhasesOf(perNormal, {root, 0.5f / root * error})};
}

/// Below this cosine, resonances of films on metals and of films that absorb are too sharp for floats.
constexpr double kMinFloatCosine = 0.05;
/// Beyond these, products of indices might leave the range of floats: that above, what is below over it, and
/// both parts of that of a film.
constexpr float kMaxFloatAbove = 30, kMaxFloatEta = 30, kMaxFloatFilm = 100;
inline bool IsModerate(float low, float high, float limit) { return low * limit >= 1 && high <= limit; }
/// Squares of normal components that floats tell from 0.
inline bool AllPositive(Floats x) { return SampledSpectrum(x).MinComponent() > 1e-30f; }
inline ClearWave ClearWaveOf(double index2, float normal) {
    return {SampledSpectrum(float(index2)), SampledSpectrum(normal)};
}

}  // namespace

ThinFilm::ThinFilm(float thickness, SampledSpectrum eta, SampledSpectrum k, SampledSpectrum lambda,
                   float etaAbove)
    : etaAbove_(etaAbove),
      absorbs_(bool(k)),
      isModerate_(IsModerate(eta.MinComponent(), eta.MaxComponent(), kMaxFloatFilm) &&
                  k.MaxComponent() <= kMaxFloatFilm && IsModerate(etaAbove, etaAbove, kMaxFloatAbove)),
      eta_(eta),
      k_(k) {
    const Doubles n = ToDoubles(eta.Raw()), kappa = ToDoubles(k.Raw());
    const FloatPair re = SplitOf(n * n - kappa * kappa);
    index2Re_ = re.high;
    index2ReRest_ = re.low;
    // As much as keeps a root from being 0.
    index2Im_ = Max(2 * eta * k, SampledSpectrum(1e-15f));
    const FloatComplex inverse2 = InverseSquare({eta.Raw(), k.Raw()}), inverse4 = inverse2 * inverse2;
    inverse2Re_ = inverse2.re;
    inverse2Im_ = inverse2.im;
    inverse4Re_ = inverse4.re;
    inverse4Im_ = inverse4.im;
    const FloatPair quarters = SplitOf(8 * double(thickness) / ToDoubles(lambda.Raw()));
    quarters_ = quarters.high;
    quartersRest_ = quarters.low;
}

ThinFilm::Shares ThinFilm::OnDielectric(float cosTheta_i, float eta) const {
    // Squared indices relative to the vacuum, what Snell's law keeps, and the squared normal component on the
    // other side.
    const double index2Above = Sqr(double(etaAbove_)), index2Below = index2Above * Sqr(double(eta));
    const double index2 = cosTheta_i < 0 ? index2Below : index2Above,
                 otherIndex2 = cosTheta_i < 0 ? index2Above : index2Below;
    const double c = std::clamp(double(std::abs(cosTheta_i)), kMinCosine, 1.0);
    const double s2 = index2 * (1 - c) * (1 + c), other2 = otherIndex2 - s2;
    const bool passes = other2 > 0;
    if (!passes && !absorbs_) return {SampledSpectrum(1), SampledSpectrum(0)};

    const float normal = etaAbove_ * (cosTheta_i < 0 ? eta : 1) * float(c),
                otherNormal = std::sqrt(float(std::abs(other2)));
    const FloatPair film2 = FloatPair{index2Re_.Raw(), index2ReRest_.Raw()} - SplitOf(s2);
    const FloatPair quarters{quarters_.Raw(), quartersRest_.Raw()};
    const bool isModerate = isModerate_ && IsModerate(eta, eta, kMaxFloatEta);
    if (passes && !absorbs_ && isModerate && AllPositive(film2.high)) {
        const ClearFilm film = ClearFilmOf(film2, quarters);
        const SampledSpectrum transmitted =
            PassedByClear(ClearWaveOf(index2, normal), {index2Re_, film.normal},
                          ClearWaveOf(otherIndex2, otherNormal), film.phases.cos);
        return {1 - transmitted, transmitted};
    }
    if (c >= kMinFloatCosine && isModerate) {
        const FloatFilm film = FloatFilmOf(film2, index2Im_.Raw(), {inverse2Re_.Raw(), inverse2Im_.Raw()},
                                           {inverse4Re_.Raw(), inverse4Im_.Raw()}, quarters);
        const float parallel = normal / float(index2), otherParallel = otherNormal / float(otherIndex2);
        if (!passes)
            return {
                MeanOf(ReflectedOver(film, normal, film.s, film.s2, {Floats{}, SplatFloat(otherNormal)}),
                       ReflectedOver(film, parallel, film.p, film.p2, {Floats{}, SplatFloat(otherParallel)})),
                SampledSpectrum(0)};
        const FloatShares s = BetweenReal(film, normal, film.s, film.s2, otherNormal),
                          p = BetweenReal(film, parallel, film.p, film.p2, otherParallel);
        const SampledSpectrum reflected = MeanOf(s.reflected, p.reflected);
        return {reflected, MeanOf(s.transmitted, p.transmitted, 1 - reflected)};
    }
    const DoubleTerms terms = DoubleTermsOf({eta_.Raw(), k_.Raw()}, s2, quarters);
    return Between(RealWave(index2, index2 * c * c), terms.film, RealWave(otherIndex2, other2), terms.trip);
}

ThinFilm::Metal ThinFilm::MetalUnder(SampledSpectrum eta, SampledSpectrum k) const {
    const FloatComplex index{(eta * etaAbove_).Raw(), (k * etaAbove_).Raw()}, index2 = index * index;
    const FloatComplex inverse2 = InverseSquare(index);
    const SampledSpectrum norm = index.SquaredNorm();
    Metal metal;
    metal.eta = index.re;
    metal.k = index.im;
    metal.index2Re = index2.re;
    metal.index2Im = index2.im;
    metal.inverse2Re = inverse2.re;
    metal.inverse2Im = inverse2.im;
    metal.isModerate = isModerate_ && norm.MaxComponent() <= Sqr(kMaxFloatFilm) &&
                       norm.MinComponent() >= 1 / Sqr(kMaxFloatFilm);
    return metal;
}

SampledSpectrum ThinFilm::OnConductor(float cosTheta_i, const Metal& metal) const {
    const double indexAbove = double(etaAbove_), index2Above = Sqr(indexAbove);
    const double c = std::clamp(double(cosTheta_i), kMinCosine, 1.0), s2 = index2Above * (1 - c) * (1 + c);
    const FloatPair quarters{quarters_.Raw(), quartersRest_.Raw()};
    if (c < kMinFloatCosine || !metal.isModerate) {
        const DoubleTerms terms = DoubleTermsOf({eta_.Raw(), k_.Raw()}, s2, quarters);
        const Complex index{ToDoubles(metal.eta.Raw()), ToDoubles(metal.k.Raw())};
        return ReflectedOn({{Splat(index2Above)}, {Splat(indexAbove * c)}}, terms.film, WaveIn(index, s2),
                           terms.trip);
    }
    const auto normal = float(indexAbove * c);
    const FloatPair film2 = FloatPair{index2Re_.Raw(), index2ReRest_.Raw()} - SplitOf(s2);
    const FloatComplex below = Root(FloatComplex{metal.index2Re.Raw() - float(s2), metal.index2Im.Raw()});
    if (!absorbs_ && AllPositive(film2.high)) {
        const ClearFilm film = ClearFilmOf(film2, quarters);
        return 1 - AbsorbedUnderClear(ClearWaveOf(index2Above, normal), {index2Re_, film.normal},
                                      {metal.index2Re.Raw(), metal.index2Im.Raw()}, below, film.phases);
    }
    const FloatFilm film = FloatFilmOf(film2, index2Im_.Raw(), {inverse2Re_.Raw(), inverse2Im_.Raw()},
                                       {inverse4Re_.Raw(), inverse4Im_.Raw()}, quarters);
    const FloatComplex belowParallel = below * FloatComplex{metal.inverse2Re.Raw(), metal.inverse2Im.Raw()};
    return MeanOf(ReflectedOver(film, normal, film.s, film.s2, below),
                  ReflectedOver(film, normal / float(index2Above), film.p, film.p2, belowParallel));
}

}  // namespace lacquer
