#include "layered/paths/half_vectors/half_vector.h"

#include "layered/paths/half_vectors/one_sample.h"
#include "layered/slopes/facet_map.h"
#include "pbrt/scattering/microfacet.h"
#include "pbrt/scattering/slope_gaussian.h"

namespace lacquer::layered {
namespace {

// All directions below are turned up, as in facet_map.h, and the slopes of facets that Gaussians are over are
// the relative ones of their interface. The parameter Slopes of the templates is RelativeSlopes, or
// StackSlopes for paths whose normals are all unperturbed.

/// A boundary that the path meets, seen from one side.
template <class Slopes>
struct RoughBoundary {
    float eta;              ///< index on the far side over index on the near side; -1 for a reflection
    Slopes slopes;          ///< of the facets
    Symmetric2 covariance;  ///< of them

    float Roughness2() const { return covariance.Trace(); }
    /// Mean square by which it spreads the slopes of directions near the normal.
    float Spread2() const { return Sqr(1 - 1 / eta) * Roughness2(); }
};
/// Seen from where light comes (`isForward`) or from where it goes.
template <class Slopes>
RoughBoundary<Slopes> BoundaryOf(const PathEvent& event, bool isForward) {
    const float eta = !event.transmits ? -1 : isForward ? 1 / event.eta : event.eta;
    return {eta, Slopes(*event.interface), event.slopeCovariance};
}

// ---- Ends -----------------------------------------------------------------------------------------------

/// A rough boundary with one direction known: the prior of its facets, and what they do.
template <class Slopes>
class End {
  public:
    End(Vec3 known, const RoughBoundary<Slopes>& boundary)
        : known_(Upward(known)), eta_(boundary.eta), map_(known_, eta_), slopes_(boundary.slopes) {
        const Symmetric2 covariance = boundary.covariance, precision = covariance.Inverse();
        // Along s the prior is (1 + r x)+ exp(-x^2/2) in units x of the standard deviation, r that of s.m: an
        // untilted Gaussian across, and here one with the same mean, which is closer to all of it than one
        // that fits its peak. Its tail is that of the untilted one, which has variance 1: a Gaussian of the
        // prior's own variance draws it far too seldom, and not at one end only. Rough ends, whose maps are
        // far from linear, leave tails to walks; the figures are measured.
        constexpr float kMinCos = 1e-3f, kToTail = 0.4f, kPerRoughness = 2;
        const Slope s = slopes_.View(known_, kMinCos), cs = covariance * s;
        const float r2 = std::max(Dot(s, cs), 1e-12f), tilt = TiltOf(r2);
        tilt2_ = r2;
        const float shift = 1 / (1 + tilt), ofPrior = (1 + 2 * tilt) * shift - r2 * shift * shift;
        const float toTail = kToTail * std::max(0.f, 1 - kPerRoughness * covariance.Trace());
        const float variance = Lerp(toTail, ofPrior, 1.f);
        mean_ = shift * cs;
        precision_ = precision.PlusSquare((1 / variance - 1) / r2, s);
        covariance_ = covariance.PlusSquare((variance - 1) / r2, cs);
        atMean_ = DeflectionAt(mean_);
    }

    Slope Mean() const { return mean_; }
    Symmetric2 Precision() const { return precision_; }    ///< of the prior about its mean
    Symmetric2 Covariance() const { return covariance_; }  ///< its inverse
    /// Variance of s.m over all facets: how much the view from outside distorts their distribution.
    float Tilt2() const { return tilt2_; }
    bool IsPerturbed() const { return slopes_.IsPerturbed(); }
    const LinearDeflection& DeflectionAtMean() const { return atMean_; }
    /// As FacetMap::BoundedDeflection() has it.
    LinearDeflection DeflectionAt(Slope x) const { return map_.BoundedDeflection(slopes_.ToStack(x)); }
    /// Derivative by the facet's relative slope, from that by its slope.
    Matrix2 OverFacet(Slope x, const Matrix2& overSlope) const {
        return IsPerturbed() ? overSlope * slopes_.StackPer(x) : overSlope;
    }
    /// Gradient over the facet's relative slope, from that over the slope of the direction behind it.
    Slope GradientOverFacet(Slope x, const LinearDeflection& deflection, Slope gradient) const {
        const Slope overSlope = FacetMap::GradientOverFacet(deflection, gradient);
        return IsPerturbed() ? slopes_.StackPer(x).TransposeTimes(overSlope) : overSlope;
    }
    /// The direction behind the facet of a relative slope, and the area of relative slopes per its solid
    /// angle [1/sr]. False where no light passes.
    bool Deflect(Slope x, Vec3* u, float* slopesPerSolidAngle) const {
        FacetDeflection deflection;
        if (!slopes_.IsUp(x) || !map_.Deflection(slopes_.ToStack(x), &deflection)) return false;
        *u = deflection.u;
        *slopesPerSolidAngle = map_.SlopesPerSolidAngle(deflection) * slopes_.AreaPerStack(x);
        return true;
    }
    /// The relative slope of the facet behind which a direction is; the same area. False for facets that
    /// Deflect() cannot find. @param u  behind some facet, turned up
    bool FacetOf(Vec3 u, Slope* x, float* slopesPerSolidAngle) const {
        const JoiningFacet facet(eta_, known_, u);
        const Slope slope = facet.FacetSlope();
        if (IsPerturbed() && !(facet.Sum() * (eta_ - 1) > 0 && slopes_.Contains(slope))) return false;
        *x = slopes_.Of(slope);
        if (!slopes_.IsUp(*x)) return false;
        *slopesPerSolidAngle = facet.SlopesPerSolidAngle() * slopes_.AreaPerStack(*x);
        return true;
    }
    /// Of facets within so many standard deviations of the mean.
    bool IsFarFromTotalReflection(float deviations) const {
        return map_.IsFarFromTotalReflection(slopes_.ToStack(mean_), covariance_, deviations);
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

    Vec3 known_;
    float eta_, tilt2_;
    FacetMap map_;
    Slopes slopes_;
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

/// Derivative of the relative slope of the facet that joins two directions by that of the end behind one.
/// @param x  the relative slope of the facet
/// @param at  that of the end
template <class Slopes>
Matrix2 OverFacetOfEnd(const Slopes& slopes, Slope x, const JoiningFacet& connecting, const End<Slopes>& end,
                       Slope at, const LinearDeflection& deflection) {
    const Matrix2 j = end.OverFacet(at, connecting.OverFacetOfU(deflection));
    return slopes.IsPerturbed() ? slopes.PerStack(x) * j : j;
}

// ---- Gaussians of the path -----------------------------------------------------------------------------

/// What is known of a slope before it is drawn.
struct GuidedSlope {
    FactoredGaussian2 gaussian;
    /// Square of the number of standard deviations by which the directions beside it are off the lobe.
    float distance2 = 0;
};
/// Square of the length of a difference of slopes in standard deviations.
float Distance2(Slope difference, const Symmetric2& covariance) {
    return Dot(difference, covariance.Inverse() * difference);
}

/// From 0 at views near the normal to 1 at grazing ones, where the tilted prior falls off more slowly than
/// its Gaussian.
/// @param tilt2  End::Tilt2()
float Grazing(float tilt2) { return Sqr(tilt2) / (Sqr(tilt2) + 1); }

/// Share of the draws that walks make. They cover what Gaussians miss; where these miss nothing, they would
/// be the only noise left.
/// @param roughness2  of the path: linear models miss more the wider slopes range
/// @param grazing     Grazing() of the end
/// @param distance2   GuidedSlope's: off the lobe linear models are taken far from where they were made
/// @param tail        of the step before: a direction that its Gaussian hardly ever draws leads where the
///                    next Gaussian may be wrong, too
float ShareOfWalks(float roughness2, float grazing, float distance2, float tail = 0) {
    constexpr float kMin = 1e-4f, kMax = 0.5f, kInTail = 0.3f, kGrazing = 0.12f, kFarIfRough = 12, kFar = 40;
    const float bend2 = roughness2 * Sqr(distance2 / kFarIfRough) + Sqr(Sqr(distance2 / kFar)),
                far = kMax * bend2 / (1 + bend2);
    return std::clamp(0.5f * Sqr(roughness2) + kGrazing * grazing + far + kInTail * tail, kMin, kMax);
}

/// The roughness that counts where walks by one boundary would waste light that another, rougher one spreads.
template <class Slopes>
float MeanRoughness2(const RoughBoundary<Slopes>& drawn, float largest) {
    return std::sqrt(drawn.Roughness2() * largest);
}

/// Share of one of two boundaries that may draw a direction: the one that spreads light less is the likelier
/// one, since the other one takes a direction as it comes.
template <class Slopes>
float ShareOf(const RoughBoundary<Slopes>& boundary, const RoughBoundary<Slopes>& other) {
    constexpr float kMin = 0.03f;
    return std::clamp(other.Spread2() / (boundary.Spread2() + other.Spread2()), kMin, 1 - kMin);
}

/// The Gaussian of the slope at `end` where the direction beyond the other boundary is known.
/// @param far     the other boundary, seen from `beyond`
/// @param rounds  how often its slope is made linear; each time where the one before puts the mean
template <class Slopes>
GuidedSlope ConditionalGaussian(const End<Slopes>& end, const RoughBoundary<Slopes>& far, Vec3 beyond,
                                float opticalThickness, int rounds) {
    const Symmetric2 facets = far.covariance.Inverse();
    Slope at = end.Mean(), slow;
    GuidedSlope guided;
    for (int round = 0; round < rounds; ++round) {
        const LinearDeflection deflection = round == 0 ? end.DeflectionAtMean() : end.DeflectionAt(at);
        const JoiningFacet connecting = Join(far.eta, deflection.u, beyond);
        const Slope joined = far.slopes.Of(connecting.FacetSlope());
        const Matrix2 j = OverFacetOfEnd(far.slopes, joined, connecting, end, at, deflection);
        if (round == 0) {
            slow = end.GradientOverFacet(
                at, deflection, SlowGradient(connecting, far.eta, deflection.u, beyond, opticalThickness));
            guided.distance2 = Distance2(joined, far.covariance + j.PushForward(end.Covariance()));
        }
        const Slope gradient = slow - j.TransposeTimes(facets * joined) - end.Precision() * (at - end.Mean());
        guided.gaussian = FactoredGaussian2(at, end.Precision() + j.PullBack(facets), gradient);
        at = guided.gaussian.Mean();
    }
    return guided;
}

/// The Gaussian of the slope at the first of two ends, that at the second one integrated out.
/// @param middle      the boundary between them, seen from the first one
/// @param roughness2  largest Roughness2() of the three
template <class Slopes>
GuidedSlope MarginalGaussian(const End<Slopes>& first, const End<Slopes>& second,
                             const RoughBoundary<Slopes>& middle, float tauFirst, float tauSecond,
                             float roughness2) {
    // Reflections are linear enough at once; measured.
    const int rounds = middle.eta < 0 ? 1 : 2;
    // Under reflections these factors draw the first facet more than their gradient at one point tells,
    // unless all is rough; measured.
    const float slowScale = middle.eta < 0 ? 1 + 0.3f * std::max(0.f, 1 - 2 * roughness2) : 1;
    Slope atFirst = first.Mean(), atSecond = second.Mean(), slowA, slowB;
    GuidedSlope guided;
    for (int round = 0; round < rounds; ++round) {
        const LinearDeflection deflectionA =
                                   round == 0 ? first.DeflectionAtMean() : first.DeflectionAt(atFirst),
                               deflectionB =
                                   round == 0 ? second.DeflectionAtMean() : second.DeflectionAt(atSecond);
        const float etaA = 1 / middle.eta, etaB = middle.eta;
        const JoiningFacet connecting = Join(etaA, deflectionA.u, deflectionB.u),
                           mirrored = Join(etaB, deflectionB.u, deflectionA.u);
        const Slope joined = middle.slopes.Of(connecting.FacetSlope());
        const Matrix2 jA = OverFacetOfEnd(middle.slopes, joined, connecting, first, atFirst, deflectionA),
                      jB = OverFacetOfEnd(middle.slopes, joined, mirrored, second, atSecond, deflectionB);
        if (round == 0) {
            slowA = slowScale * first.GradientOverFacet(
                                    atFirst, deflectionA,
                                    SlowGradient(connecting, etaA, deflectionA.u, deflectionB.u, tauFirst));
            slowB = second.GradientOverFacet(
                atSecond, deflectionB, SlowGradient(mirrored, etaB, deflectionB.u, deflectionA.u, tauSecond));
        }
        // Slope in the middle where the second end is where its own factors put it.
        const Symmetric2 rest = middle.covariance + jB.PushForward(second.Covariance()),
                         spread = rest.Inverse();
        const Slope shiftB = second.Covariance() * slowB + (second.Mean() - atSecond);
        const Slope slope = joined + jB * shiftB;
        const Slope gradient =
            slowA - jA.TransposeTimes(spread * slope) - first.Precision() * (atFirst - first.Mean());
        guided.gaussian = FactoredGaussian2(atFirst, first.Precision() + jA.PullBack(spread), gradient);
        if (round == 0) guided.distance2 = Distance2(joined, rest + jA.PushForward(first.Covariance()));
        // What the second end does there.
        if (round + 1 < rounds) {
            const Slope step = guided.gaussian.Mean() - atFirst;
            atSecond += shiftB - second.Covariance() * jB.TransposeTimes(spread * (slope + jA * step));
            atFirst = guided.gaussian.Mean();
        }
    }
    return guided;
}

// ---- Steps ----------------------------------------------------------------------------------------------

/// One inner direction: drawn through the slope of a facet, or as walks draw it.
struct Step {
    float walkShare = 0;  ///< probability of a walk
    bool isWalk = false;  ///< this draw was one
    float tail = 0;       ///< from 0 to 1: how far out in the Gaussian the facet lies
    float pdfFacets = 0;  ///< density through slopes [1/sr]; not set where all draws are walks

    /// @param grazing              Grazing() of the end: there the tail begins earlier
    /// @param pdfSlope             of the facet
    /// @param slopesPerSolidAngle  of the direction
    void SetFacets(const FactoredGaussian2& gaussian, float grazing, float pdfSlope,
                   float slopesPerSolidAngle) {
        // Shares of the Gaussian's own draws beyond its 4.5 and its 3 standard deviations.
        constexpr float kRare = 5e-5f, kRareAtGrazing = 0.01f;
        const float rare = kRare + kRareAtGrazing * grazing, beyond = pdfSlope / gaussian.Peak();
        tail = rare / (rare + beyond);
        pdfFacets = pdfSlope * slopesPerSolidAngle;
    }
    /// @param pdfWalk  density of the direction drawn by walks [1/sr]
    float Pdf(float pdfWalk, const HalfVectorPolicy& policy) const {
        const float walks = walkShare > 0 ? walkShare * pdfWalk : 0, facets = (1 - walkShare) * pdfFacets;
        if (!policy.combinesDensities) return isWalk ? walks : facets;
        return walks + facets;
    }
};

/// Draws an inner direction behind the facets of an end.
/// @param walk  (u) -> draws it by a walk, u being uniform in [0,1); false if that fails
/// @param sign  of its z
template <class Slopes, class Walk>
bool SampleStep(const End<Slopes>& end, const GuidedSlope& guided, float walkShare, float sign, Rng& rng,
                const Walk& walk, Vec3* direction, Step* step) {
    step->walkShare = guided.gaussian.IsValid() ? walkShare : 1;
    const float u = rng.Uniform();
    step->isWalk = u < step->walkShare;
    if (step->isWalk) {
        if (!walk(u / step->walkShare)) return false;
        step->tail = 1;
        Slope slope;
        float slopesPerSolidAngle;
        if (step->walkShare < 1 && end.FacetOf(sign * *direction, &slope, &slopesPerSolidAngle))
            step->SetFacets(guided.gaussian, Grazing(end.Tilt2()), guided.gaussian.Pdf(slope),
                            slopesPerSolidAngle);
        return true;
    }
    const auto sample = guided.gaussian.Sample(rng.Uniform2D());
    float slopesPerSolidAngle;
    if (!end.Deflect(sample.slope, direction, &slopesPerSolidAngle)) return false;
    step->SetFacets(guided.gaussian, Grazing(end.Tilt2()), sample.pdf, slopesPerSolidAngle);
    *direction *= sign;
    return true;
}

/// For linear models; exact values have the spectrum.
float MeanThickness(const InterfacePath& path, size_t inner) {
    return path.slabs[inner]->opticalThickness.Average();
}

/// Two events: the facet of the smoother one, over whose range the other one is the more nearly linear.
template <class Slopes>
class OneInner {
  public:
    OneInner(const InterfacePath& path, const BxDFContext& context) : path_(path), context_(context) {}

    bool Sample(InnerDirections* inner) {
        const auto light = BoundaryOf<Slopes>(path_.events[0], true),
                   camera = BoundaryOf<Slopes>(path_.events[1], false);
        const bool startsAtLight = light.Spread2() < camera.Spread2();
        const RoughBoundary<Slopes>&near = startsAtLight ? light : camera,
              &far = startsAtLight ? camera : light;
        const End end(startsAtLight ? path_.wi : path_.wo, near);
        const Vec3 beyond = Upward(startsAtLight ? path_.wo : path_.wi);
        const float roughness2 = std::max(light.Roughness2(), camera.Roughness2());
        const int rounds = roughness2 > 0.08f ? 2 : 1;  // measured
        const GuidedSlope guided = ConditionalGaussian(end, far, beyond, MeanThickness(path_, 0), rounds);
        // Either end may draw it.
        forwardShare_ = ShareOf(light, camera);
        const auto walk = [&](float u) {
            return u < forwardShare_ ? SampleForward(path_, 0, context_, inner)
                                     : SampleBackward(path_, 1, context_, inner);
        };
        return SampleStep(
            end, guided,
            ShareOfWalks(MeanRoughness2(near, roughness2), Grazing(end.Tilt2()), guided.distance2),
            path_.signs[0], *context_.rng, walk, &(*inner)[0], &step_);
    }
    float Pdf(const PathTerms& terms, const HalfVectorPolicy& policy) const {
        return step_.Pdf(Lerp(forwardShare_, terms.backward[1], terms.forward[0]), policy);
    }

  private:
    const InterfacePath& path_;
    const BxDFContext& context_;
    float forwardShare_ = 0;  ///< of the walks
    Step step_;
};

/// Three events: the facet at the more grazing end, then the direction on the other side of the middle by
/// the facet there or at the second end.
template <class Slopes>
class TwoInner {
  public:
    TwoInner(const InterfacePath& path, const BxDFContext& context)
        : path_(path),
          context_(context),
          startsAtLight_(std::abs(path.wi.z) < std::abs(path.wo.z)),
          firstBoundary_(BoundaryOf<Slopes>(path.events[startsAtLight_ ? 0 : 2], startsAtLight_)),
          secondBoundary_(BoundaryOf<Slopes>(path.events[startsAtLight_ ? 2 : 0], !startsAtLight_)),
          middle_(BoundaryOf<Slopes>(path.events[1], startsAtLight_)),
          beyond_(Upward(startsAtLight_ ? path.wo : path.wi)) {
        // Its distribution widens where the factors beside it bend it; the figure is measured.
        middle_.covariance = middle_.covariance * (1 + 1.2f * middle_.Roughness2());
        roughness2_ =
            std::max({firstBoundary_.Roughness2(), secondBoundary_.Roughness2(), middle_.Roughness2()});
        endShare_ = ShareOf(secondBoundary_, middle_);
    }

    bool Sample(InnerDirections* inner) {
        const size_t innerFirst = startsAtLight_ ? 0 : 1, innerSecond = 1 - innerFirst;
        const float tauSecond = MeanThickness(path_, innerSecond);
        const End endFirst(startsAtLight_ ? path_.wi : path_.wo, firstBoundary_),
            endSecond(beyond_, secondBoundary_);
        const GuidedSlope marginal = MarginalGaussian(
            endFirst, endSecond, middle_, MeanThickness(path_, innerFirst), tauSecond, roughness2_);
        const auto walkFromEnd = [&](float) {
            return startsAtLight_ ? SampleForward(path_, 0, context_, inner)
                                  : SampleBackward(path_, 2, context_, inner);
        };
        if (!SampleStep(endFirst, marginal,
                        ShareOfWalks(roughness2_, Grazing(endFirst.Tilt2()), marginal.distance2),
                        path_.signs[innerFirst], *context_.rng, walkFromEnd, &(*inner)[innerFirst], &first_))
            return false;

        const int rounds = roughness2_ > 0.3f ? 2 : 1;
        const Vec3 known = path_.signs[innerFirst] * (*inner)[innerFirst];
        const float rarity = std::max(first_.tail, DifficultyOfMiddle(known));
        // The second end may draw it, or the middle as it is seen from the direction just drawn.
        const auto walk = [&](float u) {
            const bool isFromEnd = u < endShare_;
            return isFromEnd == startsAtLight_
                       ? SampleBackward(path_, startsAtLight_ ? 2 : 1, context_, inner)
                       : SampleForward(path_, startsAtLight_ ? 1 : 0, context_, inner);
        };
        const auto drawSecond = [&](const End<Slopes>& end, const RoughBoundary<Slopes>& own,
                                    const RoughBoundary<Slopes>& far, Vec3 farBeyond) {
            // A rough end may bend light where no linear model of a smooth middle tells.
            constexpr float kLeast = 0.8f;
            const float roughness2 = std::max(MeanRoughness2(own, roughness2_), kLeast * roughness2_);
            const GuidedSlope conditional = ConditionalGaussian(end, far, farBeyond, tauSecond, rounds);
            return SampleStep(end, conditional,
                              ShareOfWalks(roughness2, Grazing(end.Tilt2()), conditional.distance2, rarity),
                              path_.signs[innerSecond], *context_.rng, walk, &(*inner)[innerSecond],
                              &second_);
        };
        // Below this quotient of what they spread, the facet in the middle is the better one; measured.
        constexpr float kPreferMiddle = 0.5f;
        return middle_.Spread2() < kPreferMiddle * secondBoundary_.Spread2()
                   ? drawSecond(End(known, middle_), middle_, secondBoundary_, beyond_)
                   : drawSecond(endSecond, secondBoundary_, middle_, known);
    }
    float Pdf(const PathTerms& terms, const HalfVectorPolicy& policy) const {
        const float first = startsAtLight_ ? terms.forward[0] : terms.backward[2],
                    fromEnd = startsAtLight_ ? terms.backward[2] : terms.forward[0],
                    fromMiddle = startsAtLight_ ? terms.forward[1] : terms.backward[1];
        return first_.Pdf(first, policy) * second_.Pdf(Lerp(endShare_, fromMiddle, fromEnd), policy);
    }

  private:
    /// From 0 to 1: how far from linear the middle is that a direction passes. Facets between similar indices
    /// have to turn far, and close to total reflection refraction ends.
    float DifficultyOfMiddle(Vec3 known) const {
        constexpr float kDeviations = 3, kPerBend2 = 0.02f;
        if (middle_.eta < 0) return 0;
        if (middle_.eta < 1 &&
            !FacetMap(known, middle_.eta)
                 .IsFarFromTotalReflection(middle_.slopes.ToStack({}), middle_.covariance, kDeviations))
            return 1;
        return std::min(1.f, kPerBend2 * Sqr(roughness2_ / Sqr(middle_.eta - 1)));
    }

    const InterfacePath& path_;
    const BxDFContext& context_;
    bool startsAtLight_;
    RoughBoundary<Slopes> firstBoundary_, secondBoundary_, middle_;
    Vec3 beyond_;
    float roughness2_, endShare_;  ///< of walks from the second end
    Step first_, second_;
};

template <class Directions>
bool SampleDirections(const InterfacePath& path, const BxDFContext& context, HalfVectorSample* sample,
                      const HalfVectorPolicy& policy) {
    Directions directions(path, context);
    if (!directions.Sample(&sample->inner)) return false;
    const PathTerms terms = EvaluatePathTerms(path, sample->inner, context.mode);
    if (!terms.value) return false;
    sample->value = terms.value;
    sample->pdf = directions.Pdf(terms, policy);
    return sample->pdf > 0 && sample->pdf <= std::numeric_limits<float>::max();
}
template <class Slopes>
bool SamplePath(const InterfacePath& path, const BxDFContext& context, HalfVectorSample* sample,
                const HalfVectorPolicy& policy) {
    return path.numEvents == 2 ? SampleDirections<OneInner<Slopes>>(path, context, sample, policy)
                               : SampleDirections<TwoInner<Slopes>>(path, context, sample, policy);
}

/// True if light has to turn at the middle of three refractions more than facets make it turn that a linear
/// model knows: between similar indices a small error of the outer directions needs slopes of any size.
bool TurnsFarInTheMiddle(const InterfacePath& path) {
    constexpr float kMaxSlope2 = 2;  // measured; that of 45 degrees is 1
    if (path.numEvents < 3 || !path.events[1].transmits) return false;
    const auto behind = [&](int k, Vec3 outside, float eta) {
        return FacetMap(Upward(outside), eta)
            .BoundedDeflection(path.events[size_t(k)].Slopes().ToStack({}))
            .u;
    };
    const Vec3 u = behind(0, path.wi, 1 / path.events[0].eta), v = behind(2, path.wo, path.events[2].eta);
    const Slope slope = path.events[1].Slopes().Of(Join(path.events[1].eta, u, v).FacetSlope());
    return Dot(slope, slope) > kMaxSlope2;
}

bool HasPerturbedNormals(const InterfacePath& path) {
    for (int k = 0; k < path.numEvents; ++k)
        if (!path.events[size_t(k)].HasUnperturbedNormal()) return true;
    return false;
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
    if (TurnsFarInTheMiddle(path)) return false;
    // The edge of total reflection hurts less where light goes straight on: the other boundaries keep the
    // path off it; measured.
    const float deviations = path.numEvents == 2 ? 0 : path.events[1].transmits ? 1 : 2;
    const PathEvent& last = path.events[size_t(path.numEvents - 1)];
    const auto light = BoundaryOf<RelativeSlopes>(path.events[0], true),
               camera = BoundaryOf<RelativeSlopes>(last, false);
    return (light.eta > 1 || End(Upward(path.wi), light).IsFarFromTotalReflection(deviations)) &&
           (camera.eta > 1 || End(Upward(path.wo), camera).IsFarFromTotalReflection(deviations));
}

bool SampleHalfVectorPath(const InterfacePath& path, const BxDFContext& context, HalfVectorSample* sample,
                          const HalfVectorPolicy& policy) {
    return policy.knowsNormals && HasPerturbedNormals(path)
               ? SamplePath<RelativeSlopes>(path, context, sample, policy)
               : SamplePath<StackSlopes>(path, context, sample, policy);
}

SampledSpectrum EstimateByHalfVectors(const InterfacePath& path, const BxDFContext& context,
                                      const HalfVectorPolicy& policy) {
    HalfVectorSample sample;
    if (!SampleHalfVectorPath(path, context, &sample, policy)) return SampledSpectrum(0);
    return sample.value / sample.pdf;
}

}  // namespace lacquer::layered
