#include "layered/chains/half_vectors/half_vector.h"

#include "layered/chains/half_vectors/half_vector_slopes.h"
#include "pbrt/scattering/microfacet.h"

namespace lacquer::layered {
namespace {

using slopes::Gaussian;
using slopes::Matrix;
using slopes::ScaledShear;
using slopes::Slope;
using slopes::Symmetric;

// All directions below are turned up (z > 0): those inside the stack point back to where a mirror image of
// the stack's outside would be, and slopes stay what they are.

Vec3 Upward(Vec3 w) { return w.z < 0 ? -w : w; }
Slope Planar(Vec3 w) { return {w.x, w.y}; }
Vec3 NormalOfSlope(Slope m) {
    const float z = 1 / std::sqrt(1 + Dot(m, m));
    return {m.x * z, m.y * z, z};
}

/// A boundary that the chain meets, seen from one side.
struct Meeting {
    /// Index on the far side over index on the near side; -1 for a reflection, which makes all formulas of
    /// refraction those of reflection.
    float eta;
    Symmetric covariance;  ///< of the facets' slopes

    float Roughness2() const { return covariance.xx + covariance.yy; }
    /// Mean square by which it spreads the slopes of directions near the normal.
    float Spread2() const { return Sqr(1 - 1 / eta) * Roughness2(); }
};
/// Seen from where light comes (`isForward`) or from where it goes.
Meeting MeetingOf(const ChainEvent& event, bool isForward) {
    const float eta = !event.transmits ? -1 : isForward ? 1 / event.eta : event.eta;
    return {eta, {event.slopeXX, event.slopeXY, event.slopeYY}};
}

/// A direction that a facet bends to.
struct Bend {
    Slope m;               ///< slope of the facet
    Vec3 u;                ///< the new direction
    float cosIn;           ///< of u to the facet
    float cosFacet;        ///< of the facet's normal to z
    float length;          ///< of w - eta u, signed like 1 - eta
    float stretch;         ///< -length cosFacet / eta: the scale of d(cos u slope of u)/dm
    float facetPerCosine;  ///< cosFacet / cosIn = 1/(cos u + m.u)
};

// ---- Ends -----------------------------------------------------------------------------------------------

/// A rough boundary with one direction known: the prior of its facets, and what they do.
class End {
  public:
    End(Vec3 known, const Meeting& meeting) : w_(Upward(known)), eta_(meeting.eta), invEta_(1 / meeting.eta) {
        const Symmetric covariance = meeting.covariance, precision = covariance.Inverse();
        // Along s the prior is (1 + r x)+ exp(-x^2/2) in units x of the standard deviation, r that of s.m: an
        // untilted Gaussian across, and here one with the same mean and variance, which is closer to all of
        // it than one that fits its peak.
        constexpr float kMostGrazing = 1e-3f;
        const Slope s = Planar(w_) * (1 / std::max(w_.z, kMostGrazing)), cs = covariance * s;
        const float r2 = std::max(Dot(s, cs), 1e-12f), tilt = TiltOf(r2);
        const float shift = 1 / (1 + tilt), variance = (1 + 2 * tilt) * shift - r2 * shift * shift;
        mean_ = shift * cs;
        precision_ = precision.PlusSquare((1 / variance - 1) / r2, s);
        covariance_ = covariance.PlusSquare((variance - 1) / r2, cs);
        atMean_ = NearBend(mean_);
    }

    Slope Mean() const { return mean_; }
    Symmetric Precision() const { return precision_; }    ///< of the prior about its mean
    Symmetric Covariance() const { return covariance_; }  ///< its inverse
    Gaussian Prior() const { return {mean_, precision_}; }
    const Bend& BendAtMean() const { return atMean_; }  ///< as NearBend() has it

    /// False where facets within so many standard deviations of the mean reflect totally: there the value
    /// ends at an edge, and no Gaussian does.
    bool IsClearOfTotalReflection(float deviations) const {
        const Vec3 h = NormalOfSlope(mean_);
        const float cosOut = Dot(w_, h);
        // d(w.h)/dm, and from it the standard deviation of cos^2 inside.
        const Slope gradient = h.z * (Planar(w_) - cosOut * h.z * mean_);
        const float deviation = 2 * cosOut * Sqr(invEta_) * std::sqrt(Dot(gradient, covariance_ * gradient));
        return Cos2In(cosOut) > deviations * deviation;
    }

    /// Refraction at a facet of slope m, kept off the limits of total reflection and of grazing directions,
    /// where no linear model would hold.
    Bend NearBend(Slope m) const {
        constexpr float kLeastCosOut = 0.05f, kLeastCos2In = 1e-3f, kLeastCos = 0.05f;
        const Vec3 h = NormalOfSlope(m);
        const float cosOut = std::max(Dot(w_, h), kLeastCosOut);
        Bend bend = BendAt(m, h, cosOut, std::max(Cos2In(cosOut), kLeastCos2In));
        if (bend.u.z < kLeastCos) {
            bend.u.z = kLeastCos;
            bend.u = Normalize(bend.u);
        }
        bend.stretch = -bend.length * bend.cosFacet * invEta_;
        bend.facetPerCosine = bend.cosFacet / bend.cosIn;
        return bend;
    }
    /// The exact refraction. False where a facet of slope m does not let light pass between the two sides.
    bool ExactBend(Slope m, Bend* bend) const {
        const Vec3 h = NormalOfSlope(m);
        const float cosOut = Dot(w_, h);
        if (!(cosOut > 0)) return false;
        const float cos2In = Cos2In(cosOut);
        if (!(cos2In > 0)) return false;
        *bend = BendAt(m, h, cosOut, cos2In);
        return bend->u.z > 0;
    }
    /// Slope area per solid angle of the inner direction: [Walter et al. 2007] eq. 17, and 1/cos^3.
    float SlopesPerSolidAngle(const Bend& bend) const {
        return bend.cosIn * Sqr(eta_ / bend.length) / (bend.cosFacet * bend.cosFacet * bend.cosFacet);
    }

    /// d(slope of u)/dm^T applied to a gradient over the slope of u.
    Slope GradientOverFacet(const Bend& bend, Slope gradient) const {
        const Slope p = Planar(bend.u);
        const float c = bend.u.z, invC = 1 / c;
        const float along = Dot(c * bend.m - p, gradient) * bend.facetPerCosine * invC;
        return bend.stretch * invC * (gradient - along * p);
    }

  private:
    /// r phi(1/r) / Phi(1/r), of the normal density and distribution function: moments of tilted Gaussians
    /// follow from it. @param r2  r squared
    static float TiltOf(float r2) {
        if (r2 < 0.1f) return 0;  // below 1e-3
        constexpr float kInvSqrt2Pi = 0.39894228f, kInvSqrt2 = 0.70710678f;
        const float r = std::sqrt(r2), a = 1 / r;
        return 2 * kInvSqrt2Pi * r * std::exp(-0.5f * a * a) / (1 + std::erf(kInvSqrt2 * a));
    }
    float Cos2In(float cosOut) const { return 1 - (1 - cosOut * cosOut) * Sqr(invEta_); }
    Bend BendAt(Slope m, Vec3 h, float cosOut, float cos2In) const {
        const float cosIn = std::sqrt(cos2In);
        // cosOut - eta cosIn; for refraction without the cancellation near eta = 1.
        const float length = eta_ < 0 ? cosOut + cosIn : (1 - eta_ * eta_) / (cosOut + eta_ * cosIn);
        return {m, (w_ - length * h) * invEta_, cosIn, h.z, length, 0, 0};
    }

    Vec3 w_;
    float eta_, invEta_;
    Slope mean_;
    Symmetric precision_, covariance_;
    Bend atMean_;
};

// ---- Between two boundaries -----------------------------------------------------------------------------

/// The facet that joins two directions a and b: its normal lies along eta a - b.
class Joint {
  public:
    /// @param eta  index on the side of a over index on the side of b, -1 for a reflection
    Joint(float eta, Vec3 a, Vec3 b) : eta_(eta), a_(a), b_(b) {
        // For all pairs that a facet joins the sum has the sign of eta - 1, and is longer than that times the
        // cosine of the facet.
        constexpr float kLeast = 0.05f;
        invSum_ = 1 / KeepSign(eta * a.z - b.z, kLeast);
        slope_ = (eta * Planar(a) - Planar(b)) * invSum_;
    }
    slopes::Slope FacetSlope() const { return slope_; }
    /// d slope / d(slope of the facet that bends to a).
    Matrix OverFacetOfA(const Bend& bend) const {
        return ScaledShear(eta_ * bend.stretch * invSum_, slope_ - bend.m, Planar(a_) * bend.facetPerCosine);
    }
    /// Gradient over the slope of a of the logarithm of what multiplies the facets' Gaussian law:
    /// |eta - y| |1 - eta y| / (sum^4 cos a cos b), y = a.b, and transmittance e^(-tau / cos a).
    Slope SlowGradient(float opticalThickness) const {
        constexpr float kLeast = 0.2f;
        const float y = Dot(a_, b_), c = a_.z;
        const float k = eta_ / KeepSign(eta_ * y - 1, kLeast) - 1 / KeepSign(eta_ - y, kLeast);
        return k * c * (Planar(b_) - y * Planar(a_)) +
               (4 * eta_ * c * c * invSum_ + c - opticalThickness) * Planar(a_);
    }

  private:
    /// x with the sign of eta - 1, and not below that times `least`.
    float KeepSign(float x, float least) const {
        const float sign = eta_ < 1 ? -1.f : 1.f;
        return sign * std::max(sign * x, least * std::abs(eta_ - 1));
    }

    float eta_;
    Vec3 a_, b_;
    float invSum_;
    Slope slope_;
};

// ---- Gaussians of the chain -----------------------------------------------------------------------------

/// Share of the draws that come from the prior of a facet alone. It covers what linear models miss, which
/// grows with the range of the slopes; where they miss nothing, it would be the only noise left.
float DefensiveShare(float roughness2) { return std::clamp(0.5f * Sqr(roughness2), 5e-4f, 0.05f); }

/// The Gaussian of the slope at `end` where the direction beyond the other boundary is known.
/// @param far     the other boundary, seen from `beyond`
/// @param rounds  how often its slope is made linear; each time where the one before puts the mean
Gaussian ConditionalGaussian(const End& end, const Meeting& far, Vec3 beyond, float opticalThickness,
                             int rounds) {
    const Symmetric facets = far.covariance.Inverse();
    Slope at = end.Mean(), slow;
    Gaussian gaussian;
    for (int round = 0; round < rounds; ++round) {
        const Bend bend = round == 0 ? end.BendAtMean() : end.NearBend(at);
        const Joint joint(far.eta, bend.u, beyond);
        const Matrix j = joint.OverFacetOfA(bend);
        if (round == 0) slow = end.GradientOverFacet(bend, joint.SlowGradient(opticalThickness));
        const Slope gradient =
            slow - j.TransposeTimes(facets * joint.FacetSlope()) - end.Precision() * (at - end.Mean());
        gaussian = Gaussian(at, end.Precision() + j.PullBack(facets), gradient);
        at = gaussian.Mean();
    }
    return gaussian;
}

/// The Gaussian of the slope at the first of two ends, that at the second one integrated out.
/// @param middle      the boundary between them, seen from the first one
/// @param roughness2  largest Roughness2() of the three
Gaussian MarginalGaussian(const End& first, const End& second, const Meeting& middle, float tauFirst,
                          float tauSecond, float roughness2) {
    // Reflections are linear enough at once; measured.
    const int rounds = middle.eta < 0 ? 1 : 2;
    // Under reflections these factors draw the first facet more than their gradient at one point tells,
    // unless all is rough; measured.
    const float slowScale = middle.eta < 0 ? 1 + 0.3f * std::max(0.f, 1 - 2 * roughness2) : 1;
    Slope atFirst = first.Mean(), atSecond = second.Mean(), slowA, slowB;
    Gaussian gaussian;
    for (int round = 0; round < rounds; ++round) {
        const Bend bendA = round == 0 ? first.BendAtMean() : first.NearBend(atFirst),
                   bendB = round == 0 ? second.BendAtMean() : second.NearBend(atSecond);
        const Joint joint(1 / middle.eta, bendA.u, bendB.u), mirrored(middle.eta, bendB.u, bendA.u);
        const Matrix jA = joint.OverFacetOfA(bendA), jB = mirrored.OverFacetOfA(bendB);
        if (round == 0) {
            slowA = slowScale * first.GradientOverFacet(bendA, joint.SlowGradient(tauFirst));
            slowB = second.GradientOverFacet(bendB, mirrored.SlowGradient(tauSecond));
        }
        // Slope in the middle where the second end is where its own factors put it.
        const Symmetric spread = (middle.covariance + jB.Spread(second.Covariance())).Inverse();
        const Slope shiftB = second.Covariance() * slowB + (second.Mean() - atSecond);
        const Slope slope = joint.FacetSlope() + jB * shiftB;
        const Slope gradient =
            slowA - jA.TransposeTimes(spread * slope) - first.Precision() * (atFirst - first.Mean());
        gaussian = Gaussian(atFirst, first.Precision() + jA.PullBack(spread), gradient);
        // What the second end does there.
        if (round + 1 < rounds) {
            const Slope step = gaussian.Mean() - atFirst;
            atSecond += shiftB - second.Covariance() * jB.TransposeTimes(spread * (slope + jA * step));
            atFirst = gaussian.Mean();
        }
    }
    return gaussian;
}

/// Draws the slope at an end; true if it bends light. `pdf` over solid angle of the new direction.
/// @param priorShare  of the draws that come from the end's prior
bool DrawBend(const End& end, const Gaussian& gaussian, float priorShare, const HalfVectorPolicy& policy,
              Rng& rng, Bend* bend, float* pdf) {
    if (!gaussian.IsValid()) priorShare = 1;
    Gaussian::Sample sample;
    if (priorShare == 0) {
        sample = gaussian.Draw(rng);
    } else {
        const Gaussian prior = end.Prior();
        const bool isFromPrior = rng.Uniform() < priorShare;
        sample = isFromPrior ? prior.Draw(rng) : gaussian.Draw(rng);
        const Gaussian& other = isFromPrior ? gaussian : prior;
        const float share = isFromPrior ? priorShare : 1 - priorShare;
        sample.density *= share;
        if (share < 1 && policy.combinesDensities) sample.density += (1 - share) * other.Density(sample.m);
    }
    if (!end.ExactBend(sample.m, bend)) return false;
    *pdf = sample.density * end.SlopesPerSolidAngle(*bend);
    return true;
}

/// For linear models; exact values have the spectrum.
float MeanThickness(const Chain& chain, size_t inner) {
    return chain.slabs[inner]->opticalThickness.Average();
}

/// Two events: the facet of the smoother one, over whose range the other one is the more nearly linear.
bool DrawOneInner(const Chain& chain, const HalfVectorPolicy& policy, Rng& rng, ChainDirections* inner,
                  float* pdf) {
    const Meeting light = MeetingOf(chain.events[0], true), camera = MeetingOf(chain.events[1], false);
    const bool startsAtLight = light.Spread2() < camera.Spread2();
    const Meeting &near = startsAtLight ? light : camera, &far = startsAtLight ? camera : light;
    const End end(startsAtLight ? chain.wi : chain.wo, near);
    const Vec3 beyond = Upward(startsAtLight ? chain.wo : chain.wi);
    const float roughness2 = std::max(light.Roughness2(), camera.Roughness2());
    const int rounds = roughness2 > 0.08f ? 2 : 1;  // measured
    const Gaussian gaussian = ConditionalGaussian(end, far, beyond, MeanThickness(chain, 0), rounds);
    Bend bend;
    if (!DrawBend(end, gaussian, DefensiveShare(roughness2), policy, rng, &bend, pdf)) return false;
    (*inner)[0] = chain.signs[0] * bend.u;
    return true;
}

/// Three events: the facet at the more grazing end, then the direction on the other side of the middle by
/// the facet there or at the second end.
bool DrawTwoInner(const Chain& chain, const HalfVectorPolicy& policy, Rng& rng, ChainDirections* inner,
                  float* pdf) {
    const bool startsAtLight = std::abs(chain.wi.z) < std::abs(chain.wo.z);
    const Meeting first = MeetingOf(chain.events[startsAtLight ? 0 : 2], startsAtLight),
                  second = MeetingOf(chain.events[startsAtLight ? 2 : 0], !startsAtLight);
    // Its law widens where the factors beside it bend it; the figure is measured.
    Meeting middle = MeetingOf(chain.events[1], startsAtLight);
    middle.covariance = middle.covariance * (1 + 1.2f * middle.Roughness2());
    const size_t innerFirst = startsAtLight ? 0 : 1, innerSecond = 1 - innerFirst;
    const float tauSecond = MeanThickness(chain, innerSecond);

    const End endFirst(startsAtLight ? chain.wi : chain.wo, first);
    const Vec3 beyond = Upward(startsAtLight ? chain.wo : chain.wi);
    const End endSecond(beyond, second);
    const float roughness2 = std::max({first.Roughness2(), second.Roughness2(), middle.Roughness2()});
    const Gaussian marginal = MarginalGaussian(endFirst, endSecond, middle, MeanThickness(chain, innerFirst),
                                               tauSecond, roughness2);
    Bend bendFirst, bendSecond;
    float pdfFirst, pdfSecond;
    if (!DrawBend(endFirst, marginal, DefensiveShare(roughness2), policy, rng, &bendFirst, &pdfFirst))
        return false;

    const int rounds = roughness2 > 0.3f ? 2 : 1;
    const auto drawSecond = [&](const End& end, const Meeting& far, Vec3 farBeyond) {
        const Gaussian conditional = ConditionalGaussian(end, far, farBeyond, tauSecond, rounds);
        return DrawBend(end, conditional, 0, policy, rng, &bendSecond, &pdfSecond);
    };
    // Below this quotient of what they spread, the facet in the middle is the better one; measured.
    constexpr float kPreferMiddle = 0.5f;
    const bool isDrawn = middle.Spread2() < kPreferMiddle * second.Spread2()
                             ? drawSecond(End(bendFirst.u, middle), second, beyond)
                             : drawSecond(endSecond, middle, bendFirst.u);
    if (!isDrawn) return false;
    (*inner)[innerFirst] = chain.signs[innerFirst] * bendFirst.u;
    (*inner)[innerSecond] = chain.signs[innerSecond] * bendSecond.u;
    *pdf = pdfFirst * pdfSecond;
    return true;
}

}  // namespace

bool HalfVectorApplies(const Chain& chain) {
    // Rougher ones than this scatter nearly evenly, and no Gaussian of slopes does.
    constexpr float kRoughest = 2;
    for (int k = 0; k < chain.numEvents; ++k) {
        const MicrofacetSurface& surface = chain.events[size_t(k)].surface;
        if (surface.model != MicrofacetModel::Beckmann) return false;
        if (!(std::max(surface.alphaX, surface.alphaY) < kRoughest)) return false;
    }
    // The edge of total reflection hurts less where light goes straight on: the other boundaries keep the
    // chain off it; measured.
    const float deviations = chain.numEvents == 2 ? 0 : chain.events[1].transmits ? 1 : 2;
    const ChainEvent& last = chain.events[size_t(chain.numEvents - 1)];
    const Meeting light = MeetingOf(chain.events[0], true), camera = MeetingOf(last, false);
    return (light.eta > 1 || End(Upward(chain.wi), light).IsClearOfTotalReflection(deviations)) &&
           (camera.eta > 1 || End(Upward(chain.wo), camera).IsClearOfTotalReflection(deviations));
}

bool DrawHalfVectorChain(const Chain& chain, Rng& rng, ChainDirections* inner, float* pdf,
                         const HalfVectorPolicy& policy) {
    const bool isDrawn = chain.numEvents == 2 ? DrawOneInner(chain, policy, rng, inner, pdf)
                                              : DrawTwoInner(chain, policy, rng, inner, pdf);
    return isDrawn && *pdf > 0 && *pdf <= std::numeric_limits<float>::max();
}

SampledSpectrum EstimateHalfVectorChain(const Chain& chain, Rng& rng, TransportMode mode,
                                        const HalfVectorPolicy& policy) {
    ChainDirections inner;
    float pdf;
    if (!DrawHalfVectorChain(chain, rng, &inner, &pdf, policy)) return SampledSpectrum(0);
    return ChainValue(chain, inner, mode) / pdf;
}

}  // namespace lacquer::layered
