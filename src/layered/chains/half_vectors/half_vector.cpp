#include "layered/chains/half_vectors/half_vector.h"

#include "layered/slopes/facet_map.h"
#include "pbrt/scattering/microfacet.h"
#include "pbrt/scattering/slope_gaussian.h"

namespace lacquer::layered {
namespace {

// All directions below are turned up, as in facet_map.h.

/// A boundary that the chain meets, seen from one side.
struct RoughBoundary {
    float eta;              ///< index on the far side over index on the near side; -1 for a reflection
    Symmetric2 covariance;  ///< of the facets' slopes

    float Roughness2() const { return covariance.Trace(); }
    /// Mean square by which it spreads the slopes of directions near the normal.
    float Spread2() const { return Sqr(1 - 1 / eta) * Roughness2(); }
};
/// Seen from where light comes (`isForward`) or from where it goes.
RoughBoundary BoundaryOf(const ChainEvent& event, bool isForward) {
    const float eta = !event.transmits ? -1 : isForward ? 1 / event.eta : event.eta;
    return {eta, event.slopeCovariance};
}

// ---- Ends -----------------------------------------------------------------------------------------------

/// A rough boundary with one direction known: the prior of its facets, and what they do.
class End {
  public:
    End(Vec3 known, const RoughBoundary& boundary) : map_(Upward(known), boundary.eta) {
        const Symmetric2 covariance = boundary.covariance, precision = covariance.Inverse();
        // Along s the prior is (1 + r x)+ exp(-x^2/2) in units x of the standard deviation, r that of s.m: an
        // untilted Gaussian across, and here one with the same mean and variance, which is closer to all of
        // it than one that fits its peak.
        constexpr float kMostGrazing = 1e-3f;
        const Vec3 w = Upward(known);
        const Slope s = PlanarPart(w) * (1 / std::max(w.z, kMostGrazing)), cs = covariance * s;
        const float r2 = std::max(Dot(s, cs), 1e-12f), tilt = TiltOf(r2);
        const float shift = 1 / (1 + tilt), variance = (1 + 2 * tilt) * shift - r2 * shift * shift;
        mean_ = shift * cs;
        precision_ = precision.PlusSquare((1 / variance - 1) / r2, s);
        covariance_ = covariance.PlusSquare((variance - 1) / r2, cs);
        atMean_ = map_.NearBend(mean_);
    }

    const FacetMap& Map() const { return map_; }
    Slope Mean() const { return mean_; }
    Symmetric2 Precision() const { return precision_; }    ///< of the prior about its mean
    Symmetric2 Covariance() const { return covariance_; }  ///< its inverse
    FactoredGaussian2 Prior() const { return {mean_, precision_}; }
    const LinearBend& BendAtMean() const { return atMean_; }  ///< as FacetMap::NearBend() has it
    /// Of facets within so many standard deviations of the mean.
    bool IsClearOfTotalReflection(float deviations) const {
        return map_.IsClearOfTotalReflection(mean_, covariance_, deviations);
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

    FacetMap map_;
    Slope mean_;
    Symmetric2 precision_, covariance_;
    LinearBend atMean_;
};

// ---- Between two boundaries -----------------------------------------------------------------------------

/// The facet that joins a direction u to another one, w.
/// @param eta  index on the side of u over index on the side of w, -1 for a reflection
JoiningFacet Join(float eta, Vec3 u, Vec3 w) {
    // The sum of both is longer than |eta - 1| times the cosine of the facet.
    constexpr float kLeast = 0.05f;
    return {eta, w, u, kLeast * std::abs(eta - 1)};
}

/// Gradient over the slope of u of the logarithm of what multiplies the facets' Gaussian law where a facet
/// joins u to w: |eta - y| |1 - eta y| / (sum^4 cos u cos w), y = u.w, and transmittance e^(-tau / cos u).
Slope SlowGradient(const JoiningFacet& joint, float eta, Vec3 u, Vec3 w, float opticalThickness) {
    const float least = 0.2f * std::abs(eta - 1);
    const float y = Dot(u, w), c = u.z;
    const float k = eta / JoiningFacet::KeepSign(eta, eta * y - 1, least) -
                    1 / JoiningFacet::KeepSign(eta, eta - y, least);
    return k * c * (PlanarPart(w) - y * PlanarPart(u)) +
           (4 * eta * c * c * joint.OverSum() + c - opticalThickness) * PlanarPart(u);
}

// ---- Gaussians of the chain -----------------------------------------------------------------------------

/// Share of the draws that come from the prior of a facet alone. It covers what linear models miss, which
/// grows with the range of the slopes; where they miss nothing, it would be the only noise left.
float DefensiveShare(float roughness2) { return std::clamp(0.5f * Sqr(roughness2), 5e-4f, 0.05f); }

/// The Gaussian of the slope at `end` where the direction beyond the other boundary is known.
/// @param far     the other boundary, seen from `beyond`
/// @param rounds  how often its slope is made linear; each time where the one before puts the mean
FactoredGaussian2 ConditionalGaussian(const End& end, const RoughBoundary& far, Vec3 beyond,
                                      float opticalThickness, int rounds) {
    const Symmetric2 facets = far.covariance.Inverse();
    Slope at = end.Mean(), slow;
    FactoredGaussian2 gaussian;
    for (int round = 0; round < rounds; ++round) {
        const LinearBend bend = round == 0 ? end.BendAtMean() : end.Map().NearBend(at);
        const JoiningFacet joint = Join(far.eta, bend.u, beyond);
        const Matrix2 j = joint.OverFacetOfU(bend);
        if (round == 0)
            slow = FacetMap::GradientOverFacet(
                bend, SlowGradient(joint, far.eta, bend.u, beyond, opticalThickness));
        const Slope gradient =
            slow - j.TransposeTimes(facets * joint.FacetSlope()) - end.Precision() * (at - end.Mean());
        gaussian = FactoredGaussian2(at, end.Precision() + j.PullBack(facets), gradient);
        at = gaussian.Mean();
    }
    return gaussian;
}

/// The Gaussian of the slope at the first of two ends, that at the second one integrated out.
/// @param middle      the boundary between them, seen from the first one
/// @param roughness2  largest Roughness2() of the three
FactoredGaussian2 MarginalGaussian(const End& first, const End& second, const RoughBoundary& middle,
                                   float tauFirst, float tauSecond, float roughness2) {
    // Reflections are linear enough at once; measured.
    const int rounds = middle.eta < 0 ? 1 : 2;
    // Under reflections these factors draw the first facet more than their gradient at one point tells,
    // unless all is rough; measured.
    const float slowScale = middle.eta < 0 ? 1 + 0.3f * std::max(0.f, 1 - 2 * roughness2) : 1;
    Slope atFirst = first.Mean(), atSecond = second.Mean(), slowA, slowB;
    FactoredGaussian2 gaussian;
    for (int round = 0; round < rounds; ++round) {
        const LinearBend bendA = round == 0 ? first.BendAtMean() : first.Map().NearBend(atFirst),
                         bendB = round == 0 ? second.BendAtMean() : second.Map().NearBend(atSecond);
        const float etaA = 1 / middle.eta, etaB = middle.eta;
        const JoiningFacet joint = Join(etaA, bendA.u, bendB.u), mirrored = Join(etaB, bendB.u, bendA.u);
        const Matrix2 jA = joint.OverFacetOfU(bendA), jB = mirrored.OverFacetOfU(bendB);
        if (round == 0) {
            slowA = slowScale *
                    FacetMap::GradientOverFacet(bendA, SlowGradient(joint, etaA, bendA.u, bendB.u, tauFirst));
            slowB =
                FacetMap::GradientOverFacet(bendB, SlowGradient(mirrored, etaB, bendB.u, bendA.u, tauSecond));
        }
        // Slope in the middle where the second end is where its own factors put it.
        const Symmetric2 spread = (middle.covariance + jB.Spread(second.Covariance())).Inverse();
        const Slope shiftB = second.Covariance() * slowB + (second.Mean() - atSecond);
        const Slope slope = joint.FacetSlope() + jB * shiftB;
        const Slope gradient =
            slowA - jA.TransposeTimes(spread * slope) - first.Precision() * (atFirst - first.Mean());
        gaussian = FactoredGaussian2(atFirst, first.Precision() + jA.PullBack(spread), gradient);
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
bool DrawBend(const End& end, const FactoredGaussian2& gaussian, float priorShare,
              const HalfVectorPolicy& policy, Rng& rng, FacetBend* bend, float* pdf) {
    if (!gaussian.IsValid()) priorShare = 1;
    FactoredGaussian2::Sample sample;
    if (priorShare == 0) {
        sample = gaussian.Draw(rng.Uniform2D());
    } else {
        const FactoredGaussian2 prior = end.Prior();
        const bool isFromPrior = rng.Uniform() < priorShare;
        sample = (isFromPrior ? prior : gaussian).Draw(rng.Uniform2D());
        const FactoredGaussian2& other = isFromPrior ? gaussian : prior;
        const float share = isFromPrior ? priorShare : 1 - priorShare;
        sample.pdf *= share;
        if (share < 1 && policy.combinesDensities) sample.pdf += (1 - share) * other.Pdf(sample.slope);
    }
    if (!end.Map().Bend(sample.slope, bend)) return false;
    *pdf = sample.pdf * end.Map().SlopesPerSolidAngle(*bend);
    return true;
}

/// For linear models; exact values have the spectrum.
float MeanThickness(const Chain& chain, size_t inner) {
    return chain.slabs[inner]->opticalThickness.Average();
}

/// Two events: the facet of the smoother one, over whose range the other one is the more nearly linear.
bool DrawOneInner(const Chain& chain, const HalfVectorPolicy& policy, Rng& rng, ChainDirections* inner,
                  float* pdf) {
    const RoughBoundary light = BoundaryOf(chain.events[0], true),
                        camera = BoundaryOf(chain.events[1], false);
    const bool startsAtLight = light.Spread2() < camera.Spread2();
    const RoughBoundary &near = startsAtLight ? light : camera, &far = startsAtLight ? camera : light;
    const End end(startsAtLight ? chain.wi : chain.wo, near);
    const Vec3 beyond = Upward(startsAtLight ? chain.wo : chain.wi);
    const float roughness2 = std::max(light.Roughness2(), camera.Roughness2());
    const int rounds = roughness2 > 0.08f ? 2 : 1;  // measured
    const FactoredGaussian2 gaussian = ConditionalGaussian(end, far, beyond, MeanThickness(chain, 0), rounds);
    FacetBend bend;
    if (!DrawBend(end, gaussian, DefensiveShare(roughness2), policy, rng, &bend, pdf)) return false;
    (*inner)[0] = chain.signs[0] * bend.u;
    return true;
}

/// Three events: the facet at the more grazing end, then the direction on the other side of the middle by
/// the facet there or at the second end.
bool DrawTwoInner(const Chain& chain, const HalfVectorPolicy& policy, Rng& rng, ChainDirections* inner,
                  float* pdf) {
    const bool startsAtLight = std::abs(chain.wi.z) < std::abs(chain.wo.z);
    const RoughBoundary first = BoundaryOf(chain.events[startsAtLight ? 0 : 2], startsAtLight),
                        second = BoundaryOf(chain.events[startsAtLight ? 2 : 0], !startsAtLight);
    // Its law widens where the factors beside it bend it; the figure is measured.
    RoughBoundary middle = BoundaryOf(chain.events[1], startsAtLight);
    middle.covariance = middle.covariance * (1 + 1.2f * middle.Roughness2());
    const size_t innerFirst = startsAtLight ? 0 : 1, innerSecond = 1 - innerFirst;
    const float tauSecond = MeanThickness(chain, innerSecond);

    const End endFirst(startsAtLight ? chain.wi : chain.wo, first);
    const Vec3 beyond = Upward(startsAtLight ? chain.wo : chain.wi);
    const End endSecond(beyond, second);
    const float roughness2 = std::max({first.Roughness2(), second.Roughness2(), middle.Roughness2()});
    const FactoredGaussian2 marginal = MarginalGaussian(
        endFirst, endSecond, middle, MeanThickness(chain, innerFirst), tauSecond, roughness2);
    FacetBend bendFirst, bendSecond;
    float pdfFirst, pdfSecond;
    if (!DrawBend(endFirst, marginal, DefensiveShare(roughness2), policy, rng, &bendFirst, &pdfFirst))
        return false;

    const int rounds = roughness2 > 0.3f ? 2 : 1;
    const auto drawSecond = [&](const End& end, const RoughBoundary& far, Vec3 farBeyond) {
        const FactoredGaussian2 conditional = ConditionalGaussian(end, far, farBeyond, tauSecond, rounds);
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
    const RoughBoundary light = BoundaryOf(chain.events[0], true), camera = BoundaryOf(last, false);
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
