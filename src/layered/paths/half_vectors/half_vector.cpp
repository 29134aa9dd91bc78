#include "layered/paths/half_vectors/half_vector.h"

#include "layered/slopes/facet_map.h"
#include "pbrt/scattering/microfacet.h"
#include "pbrt/scattering/slope_gaussian.h"

namespace lacquer::layered {
namespace {

// All directions below are turned up, as in facet_map.h.

/// A boundary that the path meets, seen from one side.
struct RoughBoundary {
    float eta;              ///< index on the far side over index on the near side; -1 for a reflection
    Symmetric2 covariance;  ///< of the facets' slopes

    float Roughness2() const { return covariance.Trace(); }
    /// Mean square by which it spreads the slopes of directions near the normal.
    float Spread2() const { return Sqr(1 - 1 / eta) * Roughness2(); }
};
/// Seen from where light comes (`isForward`) or from where it goes.
RoughBoundary BoundaryOf(const PathEvent& event, bool isForward) {
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
        atMean_ = map_.BoundedDeflection(mean_);
    }

    const FacetMap& Map() const { return map_; }
    Slope Mean() const { return mean_; }
    Symmetric2 Precision() const { return precision_; }    ///< of the prior about its mean
    Symmetric2 Covariance() const { return covariance_; }  ///< its inverse
    FactoredGaussian2 Prior() const { return {mean_, precision_}; }
    const LinearDeflection& DeflectionAtMean() const {
        return atMean_;
    }  ///< as FacetMap::BoundedDeflection() has it
    /// Of facets within so many standard deviations of the mean.
    bool IsFarFromTotalReflection(float deviations) const {
        return map_.IsFarFromTotalReflection(mean_, covariance_, deviations);
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
    LinearDeflection atMean_;
};

// ---- Between two boundaries -----------------------------------------------------------------------------

/// The facet that joins a direction u to another one, w.
/// @param eta  index on the side of u over index on the side of w, -1 for a reflection
JoiningFacet Join(float eta, Vec3 u, Vec3 w) {
    // The sum of both is longer than |eta - 1| times the cosine of the facet.
    constexpr float kMin = 0.05f;
    return {eta, w, u, kMin * std::abs(eta - 1)};
}

/// Gradient over the slope of u of the logarithm of what multiplies the facets' Gaussian law where a facet
/// joins u to w: |eta - y| |1 - eta y| / (sum^4 cos u cos w), y = u.w, and transmittance e^(-tau / cos u).
Slope SlowGradient(const JoiningFacet& connecting, float eta, Vec3 u, Vec3 w, float opticalThickness) {
    const float least = 0.2f * std::abs(eta - 1);
    const float y = Dot(u, w), c = u.z;
    const float k = eta / JoiningFacet::KeepSign(eta, eta * y - 1, least) -
                    1 / JoiningFacet::KeepSign(eta, eta - y, least);
    return k * c * (PlanarPart(w) - y * PlanarPart(u)) +
           (4 * eta * c * c * connecting.OverSum() + c - opticalThickness) * PlanarPart(u);
}

// ---- Gaussians of the path -----------------------------------------------------------------------------

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
        const LinearDeflection deflection =
            round == 0 ? end.DeflectionAtMean() : end.Map().BoundedDeflection(at);
        const JoiningFacet connecting = Join(far.eta, deflection.u, beyond);
        const Matrix2 j = connecting.OverFacetOfU(deflection);
        if (round == 0)
            slow = FacetMap::GradientOverFacet(
                deflection, SlowGradient(connecting, far.eta, deflection.u, beyond, opticalThickness));
        const Slope gradient =
            slow - j.TransposeTimes(facets * connecting.FacetSlope()) - end.Precision() * (at - end.Mean());
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
        const LinearDeflection deflectionA = round == 0 ? first.DeflectionAtMean()
                                                        : first.Map().BoundedDeflection(atFirst),
                               deflectionB = round == 0 ? second.DeflectionAtMean()
                                                        : second.Map().BoundedDeflection(atSecond);
        const float etaA = 1 / middle.eta, etaB = middle.eta;
        const JoiningFacet connecting = Join(etaA, deflectionA.u, deflectionB.u),
                           mirrored = Join(etaB, deflectionB.u, deflectionA.u);
        const Matrix2 jA = connecting.OverFacetOfU(deflectionA), jB = mirrored.OverFacetOfU(deflectionB);
        if (round == 0) {
            slowA = slowScale *
                    FacetMap::GradientOverFacet(
                        deflectionA, SlowGradient(connecting, etaA, deflectionA.u, deflectionB.u, tauFirst));
            slowB = FacetMap::GradientOverFacet(
                deflectionB, SlowGradient(mirrored, etaB, deflectionB.u, deflectionA.u, tauSecond));
        }
        // Slope in the middle where the second end is where its own factors put it.
        const Symmetric2 spread = (middle.covariance + jB.PushForward(second.Covariance())).Inverse();
        const Slope shiftB = second.Covariance() * slowB + (second.Mean() - atSecond);
        const Slope slope = connecting.FacetSlope() + jB * shiftB;
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
bool SampleDeflection(const End& end, const FactoredGaussian2& gaussian, float priorShare,
                      const HalfVectorPolicy& policy, Rng& rng, FacetDeflection* deflection, float* pdf) {
    if (!gaussian.IsValid()) priorShare = 1;
    FactoredGaussian2::SlopeSample sample;
    if (priorShare == 0) {
        sample = gaussian.Sample(rng.Uniform2D());
    } else {
        const FactoredGaussian2 prior = end.Prior();
        const bool isFromPrior = rng.Uniform() < priorShare;
        sample = (isFromPrior ? prior : gaussian).Sample(rng.Uniform2D());
        const FactoredGaussian2& other = isFromPrior ? gaussian : prior;
        const float share = isFromPrior ? priorShare : 1 - priorShare;
        sample.pdf *= share;
        if (share < 1 && policy.combinesDensities) sample.pdf += (1 - share) * other.Pdf(sample.slope);
    }
    if (!end.Map().Deflection(sample.slope, deflection)) return false;
    *pdf = sample.pdf * end.Map().SlopesPerSolidAngle(*deflection);
    return true;
}

/// For linear models; exact values have the spectrum.
float MeanThickness(const InterfacePath& path, size_t inner) {
    return path.slabs[inner]->opticalThickness.Average();
}

/// Two events: the facet of the smoother one, over whose range the other one is the more nearly linear.
bool SampleOneInner(const InterfacePath& path, const HalfVectorPolicy& policy, Rng& rng,
                    InnerDirections* inner, float* pdf) {
    const RoughBoundary light = BoundaryOf(path.events[0], true), camera = BoundaryOf(path.events[1], false);
    const bool startsAtLight = light.Spread2() < camera.Spread2();
    const RoughBoundary &near = startsAtLight ? light : camera, &far = startsAtLight ? camera : light;
    const End end(startsAtLight ? path.wi : path.wo, near);
    const Vec3 beyond = Upward(startsAtLight ? path.wo : path.wi);
    const float roughness2 = std::max(light.Roughness2(), camera.Roughness2());
    const int rounds = roughness2 > 0.08f ? 2 : 1;  // measured
    const FactoredGaussian2 gaussian = ConditionalGaussian(end, far, beyond, MeanThickness(path, 0), rounds);
    FacetDeflection deflection;
    if (!SampleDeflection(end, gaussian, DefensiveShare(roughness2), policy, rng, &deflection, pdf))
        return false;
    (*inner)[0] = path.signs[0] * deflection.u;
    return true;
}

/// Three events: the facet at the more grazing end, then the direction on the other side of the middle by
/// the facet there or at the second end.
bool SampleTwoInner(const InterfacePath& path, const HalfVectorPolicy& policy, Rng& rng,
                    InnerDirections* inner, float* pdf) {
    const bool startsAtLight = std::abs(path.wi.z) < std::abs(path.wo.z);
    const RoughBoundary first = BoundaryOf(path.events[startsAtLight ? 0 : 2], startsAtLight),
                        second = BoundaryOf(path.events[startsAtLight ? 2 : 0], !startsAtLight);
    // Its distribution widens where the factors beside it bend it; the figure is measured.
    RoughBoundary middle = BoundaryOf(path.events[1], startsAtLight);
    middle.covariance = middle.covariance * (1 + 1.2f * middle.Roughness2());
    const size_t innerFirst = startsAtLight ? 0 : 1, innerSecond = 1 - innerFirst;
    const float tauSecond = MeanThickness(path, innerSecond);

    const End endFirst(startsAtLight ? path.wi : path.wo, first);
    const Vec3 beyond = Upward(startsAtLight ? path.wo : path.wi);
    const End endSecond(beyond, second);
    const float roughness2 = std::max({first.Roughness2(), second.Roughness2(), middle.Roughness2()});
    const FactoredGaussian2 marginal =
        MarginalGaussian(endFirst, endSecond, middle, MeanThickness(path, innerFirst), tauSecond, roughness2);
    FacetDeflection deflectionFirst, deflectionSecond;
    float pdfFirst, pdfSecond;
    if (!SampleDeflection(endFirst, marginal, DefensiveShare(roughness2), policy, rng, &deflectionFirst,
                          &pdfFirst))
        return false;

    const int rounds = roughness2 > 0.3f ? 2 : 1;
    const auto drawSecond = [&](const End& end, const RoughBoundary& far, Vec3 farBeyond) {
        const FactoredGaussian2 conditional = ConditionalGaussian(end, far, farBeyond, tauSecond, rounds);
        return SampleDeflection(end, conditional, 0, policy, rng, &deflectionSecond, &pdfSecond);
    };
    // Below this quotient of what they spread, the facet in the middle is the better one; measured.
    constexpr float kPreferMiddle = 0.5f;
    const bool isSampled = middle.Spread2() < kPreferMiddle * second.Spread2()
                               ? drawSecond(End(deflectionFirst.u, middle), second, beyond)
                               : drawSecond(endSecond, middle, deflectionFirst.u);
    if (!isSampled) return false;
    (*inner)[innerFirst] = path.signs[innerFirst] * deflectionFirst.u;
    (*inner)[innerSecond] = path.signs[innerSecond] * deflectionSecond.u;
    *pdf = pdfFirst * pdfSecond;
    return true;
}

}  // namespace

bool HalfVectorApplies(const InterfacePath& path) {
    // Rougher ones than this scatter nearly evenly, and no Gaussian of slopes does.
    constexpr float kRoughest = 2;
    for (int k = 0; k < path.numEvents; ++k) {
        const MicrofacetSurface& surface = path.events[size_t(k)].surface;
        if (surface.model != MicrofacetModel::Beckmann) return false;
        if (!(std::max(surface.alphaX, surface.alphaY) < kRoughest)) return false;
    }
    // The edge of total reflection hurts less where light goes straight on: the other boundaries keep the
    // path off it; measured.
    const float deviations = path.numEvents == 2 ? 0 : path.events[1].transmits ? 1 : 2;
    const PathEvent& last = path.events[size_t(path.numEvents - 1)];
    const RoughBoundary light = BoundaryOf(path.events[0], true), camera = BoundaryOf(last, false);
    return (light.eta > 1 || End(Upward(path.wi), light).IsFarFromTotalReflection(deviations)) &&
           (camera.eta > 1 || End(Upward(path.wo), camera).IsFarFromTotalReflection(deviations));
}

bool SampleHalfVectorPath(const InterfacePath& path, Rng& rng, InnerDirections* inner, float* pdf,
                          const HalfVectorPolicy& policy) {
    const bool isSampled = path.numEvents == 2 ? SampleOneInner(path, policy, rng, inner, pdf)
                                               : SampleTwoInner(path, policy, rng, inner, pdf);
    return isSampled && *pdf > 0 && *pdf <= std::numeric_limits<float>::max();
}

SampledSpectrum EstimateByHalfVectors(const InterfacePath& path, Rng& rng, TransportMode mode,
                                      const HalfVectorPolicy& policy) {
    InnerDirections inner;
    float pdf;
    if (!SampleHalfVectorPath(path, rng, &inner, &pdf, policy)) return SampledSpectrum(0);
    return PathContribution(path, inner, mode) / pdf;
}

}  // namespace lacquer::layered
