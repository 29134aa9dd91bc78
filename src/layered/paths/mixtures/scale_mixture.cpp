#include "layered/paths/mixtures/scale_mixture.h"

#include "layered/paths/half_vectors/one_sample.h"
#include "layered/paths/mixtures/slope_mixtures.h"

namespace lacquer::layered {
namespace {

/// @param sign  of z of the inner direction next to the end
/// @param eta   index inside over index outside
PathEnd MakePathEnd(const PathEvent& event, Vec3 outside, float sign, float eta) {
    return {Upward(outside),
            sign,
            eta,
            event.slopeCovariance,
            event.MaxAlpha(),
            event.Slopes(),
            &ScalesOf(event.surface.model)};
}
/// The end where light comes in.
PathEnd LightEnd(const InterfacePath& path) {
    const PathEvent& event = path.events[0];
    return MakePathEnd(event, path.wi, path.signs[0], 1 / event.eta);
}
/// The end where it leaves.
PathEnd CameraEnd(const InterfacePath& path) {
    const size_t inner = size_t(path.NumInner() - 1);
    const PathEvent& event = path.events[inner + 1];
    return MakePathEnd(event, path.wo, path.signs[inner], event.eta);
}

/// The slopes at an interface between two inner directions. Reflection also grows with the angle between
/// them, which widens the slopes that matter a little.
JoiningFacets FacetsBetween(const PathEvent& event, float kappa) {
    constexpr float kWidening = 1.2f;
    const float widening = event.transmits ? 1 : 1 + kWidening * event.slopeCovariance.Trace();
    return {kappa, event.slopeCovariance * widening, &ScalesOf(event.surface.model), event.Slopes()};
}
JoiningFacets FacetsOf(const PathEnd& end) { return {end.eta, end.covariance, end.scales, end.slopes}; }

/// Balance of both kinds of sampling.
/// @param share  of OneSample
SampledSpectrum Weigh(const PathTerms& terms, float share, float pdfOneSample, float pdfFacets) {
    const float pdf = share * pdfOneSample + (1 - share) * pdfFacets;
    return pdf > 0 && pdf < Infinity ? terms.value * (1 / pdf) : SampledSpectrum(0);
}

/// The direction behind a facet of an end. False if no light passes there.
bool Deflection(const PathEnd& end, Slope x, Vec3* u) {
    FacetDeflection deflection;
    if (!end.slopes.IsUp(x) || !FacetMap(end.w, end.eta).Deflection(end.slopes.ToStack(x), &deflection))
        return false;
    *u = deflection.u;
    return true;
}

/// Density of u over solid angle, for facets whose slopes have the density facets.Pdf(slope). 0 where
/// Deflection() finds none.
template <class Facets>
float PdfOfDirection(const PathEnd& end, const Facets& facets, Vec3 u) {
    const JoiningFacet facet(end.eta, end.w, u);
    if (!end.slopes.IsPerturbed()) return facets.Pdf(facet.FacetSlope()) * facet.SlopesPerSolidAngle();
    if (!(facet.Sum() * (end.eta - 1) > 0 && end.slopes.Contains(facet.FacetSlope()))) return 0;
    const Slope x = end.slopes.Of(facet.FacetSlope());
    if (!end.slopes.IsUp(x)) return 0;
    return facets.Pdf(x) * facet.SlopesPerSolidAngle() * end.slopes.AreaPerStack(x);
}

/// From 0 in the lobe to 1 far from it. @param distance  of facets: SecondFacet::Distance()
float FarShare(float distance) {
    constexpr float kFarDistance = 50;  // measured
    return distance / (distance + kFarDistance);
}

/// Beyond this distance light that any one event alone turns far outshines what they all turn a little. One
/// connection finds one of these events; all connections together find it with less noise. Measured.
constexpr float kFarthest = 15;

/// Two interfaces that light goes through: one inner direction, drawn by the facet of the smoother one.
class TwoEvents {
  public:
    TwoEvents(const InterfacePath& path, bool countsWalks)
        : path_(path),
          countsWalks_(countsWalks),
          isFromLight_(path.events[0].MeanAlpha() <= path.events[1].MeanAlpha()),
          base_(isFromLight_ ? LightEnd(path) : CameraEnd(path)),
          other_(isFromLight_ ? CameraEnd(path) : LightEnd(path)),
          facet_(base_, other_.w, FacetsOf(other_)),
          oneSample_(path, kSmallestShare) {}

    SampledSpectrum Estimate(const BxDFContext& context) const {
        if (facet_.Distance() > kFarthest) return EstimateByAllConnections(path_, context);
        const float share = facet_.IsUsable() ? ShareOfOneSample() : 1;
        InnerDirections inner;
        if (context.rng->Uniform() < share ? !oneSample_.Sample(path_, context, &inner)
                                           : !SampleFacet(*context.rng, &inner))
            return SampledSpectrum(0);
        const PathTerms terms = EvaluatePathTerms(path_, inner, context.mode);
        if (!terms.value) return terms.value;
        const float pdfFacet =
            share < 1 ? PdfOfDirection(base_.end, facet_, inner[0] * base_.end.toInner) : 0;
        return Weigh(terms, share, countsWalks_ ? oneSample_.Pdf(path_, terms) : 0, pdfFacet);
    }

  private:
    static constexpr float kSmallestShare = 0.1f;  ///< of each of OneSample's meetings

    /// Where both interfaces are rough their maps of slopes are far from linear; and so is refraction to a
    /// smaller index, which ends in total reflection. Far from the lobes walks find what facets do not.
    float ShareOfOneSample() const {
        constexpr float kMin = 0.05f, kMax = 0.5f, kFar = 0.4f;  // measured
        const float alpha = base_.end.maxAlpha, otherAlpha = other_.maxAlpha;
        const float refracted = base_.end.eta < 1 || other_.eta < 1 ? 0.5f * std::max(alpha, otherAlpha) : 0;
        const float far = kFar * FarShare(facet_.Distance());
        return std::min(kMin + 1.2f * alpha * otherAlpha + refracted + far, kMax);
    }
    bool SampleFacet(Rng& rng, InnerDirections* inner) const {
        Vec3 u;
        if (!Deflection(base_.end, facet_.Sample(rng), &u)) return false;
        (*inner)[0] = u * base_.end.toInner;
        return true;
    }

    const InterfacePath& path_;
    bool countsWalks_, isFromLight_;
    EndModel base_;
    PathEnd other_;
    SecondFacet facet_;
    OneSample oneSample_;
};

/// Two outer events and one between: the facets of the outer ones are drawn after each other.
class ThreeEvents {
  public:
    ThreeEvents(const InterfacePath& path, bool countsWalks)
        : path_(path),
          countsWalks_(countsWalks),
          // The more grazing end is further from linear: the other one can still follow it.
          isFromLight_(std::abs(path.wi.z) <= std::abs(path.wo.z)),
          own_(isFromLight_ ? LightEnd(path) : CameraEnd(path)),
          other_(isFromLight_ ? CameraEnd(path) : LightEnd(path)),
          joining_(FacetsBetween(path.events[1], KappaOf(path.events[1]))),
          first_(own_, other_, joining_),
          far_(FarShare(first_.Distance())),
          oneSample_(path, kSmallestShare + far_ * (kSmallestShareFar - kSmallestShare)) {}

    SampledSpectrum Estimate(const BxDFContext& context) const {
        if (first_.Distance() > kFarthest) return EstimateByAllConnections(path_, context);
        // Draw the first direction, or both by walks.
        const float share = ShareOfOneSample();
        const bool samplesFacets = context.rng->Uniform() >= share;
        InnerDirections inner;
        Vec3 u, v;
        if (samplesFacets ? !SampleFirst(context, &u) : !oneSample_.Sample(path_, context, &inner))
            return SampledSpectrum(0);
        if (!samplesFacets) u = inner[OwnIndex()] * own_.end.toInner;

        // Then the second one. If its distribution cannot be told, facets do not sample such a u at all.
        const SecondFacet second(other_, u, joining_);
        if (samplesFacets) {
            if (!second.IsUsable() || !Deflection(other_.end, second.Sample(*context.rng), &v))
                return SampledSpectrum(0);
            inner[OwnIndex()] = u * own_.end.toInner;
            inner[1 - OwnIndex()] = v * other_.end.toInner;
        } else {
            v = inner[1 - OwnIndex()] * other_.end.toInner;
        }

        const PathTerms terms = EvaluatePathTerms(path_, inner, context.mode);
        if (!terms.value) return terms.value;
        const float pdfFacets =
            second.IsUsable() ? PdfFirst(terms, u) * PdfOfDirection(other_.end, second, v) : 0;
        return Weigh(terms, share, countsWalks_ ? oneSample_.Pdf(path_, terms) : 0, pdfFacets);
    }

  private:
    /// Of each of OneSample's connections, in the lobe and far from it, where any event may turn the light.
    static constexpr float kSmallestShare = 0.001f, kSmallestShareFar = 0.2f;

    /// Rough events take the path far from linear and make tails matter, and far from the lobe walks find
    /// what facets do not, as in TwoEvents.
    float ShareOfOneSample() const {
        constexpr float kFar = 0.4f;
        const float outer = std::max(own_.end.maxAlpha, other_.end.maxAlpha);
        const float refracted = own_.end.eta < 1 || other_.end.eta < 1 ? outer : 0;
        const float near = std::clamp(path_.events[1].MaxAlpha() + Sqr(outer) + refracted, 0.03f, 0.4f);
        return std::min(near + kFar * far_, 0.5f);
    }
    /// Of the rest, how many draw the first facet as it is visible from outside and let only the second one
    /// look at the event between: a rough one matters little to the first.
    float ShareOfVisible() const {
        return first_.IsUsable() ? std::min(1.5f * path_.events[1].MaxAlpha(), 0.9f) : 1;
    }
    /// Of the end that is drawn first.
    size_t OwnIndex() const { return isFromLight_ ? 0 : 1; }
    float KappaOf(const PathEvent& event) const {
        if (!event.transmits) return -1;
        return isFromLight_ ? 1 / event.eta : event.eta;
    }
    bool SampleFirst(const BxDFContext& context, Vec3* u) const {
        if (context.rng->Uniform() >= ShareOfVisible())
            return Deflection(own_.end, first_.Sample(*context.rng), u);
        InnerDirections inner;
        if (isFromLight_ ? !SampleForward(path_, 0, context, &inner)
                         : !SampleBackward(path_, 2, context, &inner))
            return false;
        *u = inner[OwnIndex()] * own_.end.toInner;
        return true;
    }
    float PdfFirst(const PathTerms& terms, Vec3 u) const {
        const float visible = isFromLight_ ? terms.forward[0] : terms.backward[2], share = ShareOfVisible();
        return share < 1 ? share * visible + (1 - share) * PdfOfDirection(own_.end, first_, u) : visible;
    }

    const InterfacePath& path_;
    bool countsWalks_, isFromLight_;
    EndModel own_, other_;
    JoiningFacets joining_;
    FirstFacet first_;
    float far_;  ///< FarShare()
    OneSample oneSample_;
};

/// True if facets are seen at so flat an angle that their visible part is far from Gaussian at any scale, or
/// if many of them reflect totally: a mixture would miss what is bright.
bool IsFarFromGaussian(const PathEvent& event, Vec3 w, float eta) {
    constexpr float kMaxTilt2 =
        0.35f;  // variance of the slopes along the view, in units of its own; measured
    constexpr float kDeviations = 1;
    constexpr float kSmallestCos = 1e-6f;
    const Vec3 up = Upward(w);
    const RelativeSlopes slopes = event.Slopes();
    const Slope view = slopes.View(up, kSmallestCos);
    if (Dot(view, event.slopeCovariance * view) > kMaxTilt2) return true;
    return eta < 1 && !FacetMap(up, eta).IsFarFromTotalReflection(slopes.ToStack({}), event.slopeCovariance,
                                                                  kDeviations);
}
bool IsFarFromGaussian(const InterfacePath& path) {
    const PathEvent &first = path.events[0], &last = path.events[size_t(path.NumInner())];
    return IsFarFromGaussian(first, path.wi, 1 / first.eta) || IsFarFromGaussian(last, path.wo, last.eta);
}

}  // namespace

// By time to equal error of both on grids of alphas from 0.05 to 0.5 and indices 1.25, 1.5, 2 and below 1.
bool ScaleMixtureIsWorthwhile(const InterfacePath& path) {
    const PathEvent &first = path.events[0], &last = path.events[size_t(path.NumInner())];
    const float outer = std::max(first.MeanAlpha(), last.MeanAlpha());
    const bool entersSmallerIndex = first.eta > 1 || last.eta < 1;
    if (path.numEvents == 2) return !entersSmallerIndex || outer < 0.35f;
    if (entersSmallerIndex) return outer < 0.25f;
    const PathEvent& middle = path.events[1];
    if (middle.transmits) return outer < 0.4f;
    // A reflection much wider than the lobes that refraction makes needs no care: both ends draw their own.
    return middle.MeanAlpha() < 1.2f * (1 - 1 / last.eta);
}

SampledSpectrum EstimateByScaleMixture(const InterfacePath& path, const BxDFContext& context,
                                       bool countsWalks) {
    if (IsFarFromGaussian(path)) return EstimateByAllConnections(path, context);
    return path.numEvents == 2 ? TwoEvents(path, countsWalks).Estimate(context)
                               : ThreeEvents(path, countsWalks).Estimate(context);
}

}  // namespace lacquer::layered
