#include "pbrt/bxdfs/multiscatter_dielectric.h"

#include <type_traits>
#include <utility>

namespace lacquer {

// ---- One event --------------------------------------------------------------------------------------------

template <MicrofacetDistribution Distribution>
auto MultiscatterDielectricBxDF<Distribution>::SingleEventOf(Vec3 wo, Vec3 wi) const -> SingleEvent {
    if (SameHemisphere(wo, wi)) {
        const MicrofacetTerms terms = ReflectionTerms(facets_, wo, wi);
        const float f = FresnelDielectric(Dot(wo, terms.wm), eta_) * terms.value;
        return {f, f};
    }
    const float etap = IndexAcross(SideOf(wo));
    const MicrofacetTerms terms = TransmissionTerms(facets_, wo, wi, etap);
    if (!(terms.value > 0)) return {};
    const auto lambda = [this](Vec3 w) { return AreasOf(facets_, w.z > 0 ? -w : w).front / std::abs(w.z); };
    const float f = (1 - FresnelDielectric(Dot(wo, terms.wm), eta_)) * terms.value *
                    OppositeShadowingRatio(lambda(wo), lambda(wi));
    return {f, f / Sqr(etap)};
}

template <MicrofacetDistribution Distribution>
float MultiscatterDielectricBxDF<Distribution>::DensityOf(float single, Vec3 wo, Vec3 wi) const {
    return (single + RescatteredByDielectric(facets_, wo) * Inv2Pi) * std::abs(wi.z);
}

template <MicrofacetDistribution Distribution>
BxDFValue MultiscatterDielectricBxDF<Distribution>::Evaluate(Vec3 wo, Vec3 wi,
                                                             const BxDFContext& context) const {
    if (wo.z == 0 || wi.z == 0) return {};
    const bool isReflection = SameHemisphere(wo, wi);
    if (!Any(context.sides, isReflection ? Lobes::Reflection : Lobes::Transmission)) return {};
    const SingleEvent single = SingleEventOf(wo, wi);
    BxDFValue value;
    if (context.needsPdf) {
        value.pdf = DensityOf(single.f, wo, wi);
        value.pdfReverse = DensityOf(single.fReverse, wi, wo);
    }
    const bool isScaled = !isReflection && context.mode == TransportMode::Radiance;
    const float scale = isScaled ? 1 / Sqr(IndexAcross(SideOf(wo))) : 1.f;
    value.f = SampledSpectrum(scale * (single.f + EstimateRescattered(wo, wi, *context.rng)));
    return value;
}

template <MicrofacetDistribution Distribution>
float MultiscatterDielectricBxDF<Distribution>::Pdf(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    if (wo.z == 0 || wi.z == 0) return 0;
    if (!Any(context.sides, SameHemisphere(wo, wi) ? Lobes::Reflection : Lobes::Transmission)) return 0;
    return DensityOf(SingleEventOf(wo, wi).f, wo, wi);
}

// ---- Walks ------------------------------------------------------------------------------------------------

template <MicrofacetDistribution Distribution>
float MultiscatterDielectricBxDF<Distribution>::TurnDensity(float side, Vec3 w, Vec3 wm, Vec3 to,
                                                            bool isReflected) const {
    const float etap = IndexAcross(side), dotO = Dot(w, wm), fresnel = FresnelDielectric(dotO, etap);
    if (isReflected) return 0.25f * fresnel * facets_.D(wm);
    // As TransmissionTerms().
    return (1 - fresnel) * facets_.D(wm) * std::abs(dotO * Dot(to, wm)) * Sqr(etap) /
           LengthSquared(w + etap * to);
}

template <MicrofacetDistribution Distribution>
float MultiscatterDielectricBxDF<Distribution>::TurnTowards(const Walk& walk, Vec3 wi) const {
    // In the frame of the walk's side; the exit is on the other one where z < 0.
    const Vec3 w = -walk.ray.d, to = walk.side * wi;
    const bool isReflected = to.z > 0;
    const Vec3 sum = w + (isReflected ? 1 : IndexAcross(walk.side)) * to;
    const float length2 = LengthSquared(sum);
    if (!(length2 > 0)) return 0;
    const Vec3 wm = sum * std::copysign(1 / std::sqrt(length2), sum.z);
    const float dotI = Dot(to, wm);
    if (!(Dot(w, wm) > 0) || !(isReflected ? dotI > 0 : dotI < 0)) return 0;
    return TurnDensity(walk.side, w, wm, to, isReflected) / walk.ray.areas.back;
}

template <MicrofacetDistribution Distribution>
bool MultiscatterDielectricBxDF<Distribution>::TurnAt(Vec3 wm, bool isReflected, Walk& walk) const {
    const Vec3 w = -walk.ray.d;
    if (isReflected) {
        walk.ray = MicroRay(facets_, Normalize(Reflect(w, wm)));
        return true;
    }
    const std::optional<Refraction> refracted = Refract(w, wm, IndexAcross(walk.side));
    if (!refracted) return false;
    walk.side = -walk.side;
    walk.depth = walk.depth.OnOtherSide();
    walk.ray = MicroRay(facets_, -Normalize(refracted->w));
    return true;
}

// The balance heuristic over the two starts, with the densities of directions and depths. A flight along d
// between two heights has the density `back / cosine` times what it has in the other direction over `front`,
// so that of their quotient over a whole path only the ends are left: for each, what the facet there does,
// over the area of that facet seen from within, times the probability to get there from outside.
template <MicrofacetDistribution Distribution>
float MultiscatterDielectricBxDF<Distribution>::EstimateRescattered(Vec3 wo, Vec3 wi, Rng& rng) const {
    // What seldom happens is seldom looked for: nearly smooth facets send about a thousandth of the light on
    // to another one, and a walk costs as much as all else. Four times the variance of so little is not seen.
    constexpr float kMin = 0.25f, kPerShare = 64;
    const float probability = std::clamp(kPerShare * RescatteredByDielectric(facets_, wo), kMin, 1.f);
    if (probability < 1 && rng.Uniform() >= probability) return 0;
    // Start at either end: f is symmetric but for the squared index.
    float scale = 2 / probability;
    if (rng.Uniform() < 0.5f) {
        if (!SameHemisphere(wo, wi)) scale *= Sqr(IndexAcross(SideOf(wo)));
        std::swap(wo, wi);
    }
    const float exitSide = SideOf(wi);
    const MicroRay entry(facets_, SideOf(wo) * wo), outgoing(facets_, exitSide * wi);
    Walk walk = StartAt(wo);
    float sum = 0, start = 0;
    for (int event = 1; walk.depth.Fly(walk.ray, rng); ++event) {
        if (event > 1) {
            const MicroDepth depth = walk.side == exitSide ? walk.depth : walk.depth.OnOtherSide();
            const float end = TurnTowards(walk, wi) * depth.EscapeOverCosine(outgoing);
            const float squaredIndex = walk.side == exitSide ? 1 : Sqr(IndexAcross(walk.side));
            if (end > 0) sum += end * start / (start + end / squaredIndex);
        }
        if (event == maxEvents_) break;
        const Vec3 w = -walk.ray.d, wm = SampleFacet(facets_, w, rng);
        const float side = walk.side, etap = IndexAcross(side);
        const bool isReflected = rng.Uniform() < FresnelDielectric(Dot(w, wm), etap);
        if (event == 1) start = walk.depth.EscapeOverCosine(entry);
        if (!TurnAt(wm, isReflected, walk)) break;
        if (event == 1)
            start *=
                TurnDensity(side, w, wm, side * walk.side * walk.ray.d, isReflected) / walk.ray.areas.front;
        else if (!isReflected)
            start *= Sqr(etap);
        start = start > 0 ? std::min(start, 1e30f) : 0;
    }
    return scale * sum;
}

// ---- Sampling ---------------------------------------------------------------------------------------------

template <MicrofacetDistribution Distribution>
float MultiscatterDielectricBxDF<Distribution>::ReflectionProbability(float fresnel, Vec3 w,
                                                                      Lobes sides) const {
    if (sides == Lobes::BothSides) return fresnel;
    // What begins on the wrong side comes back with about this probability. Not less: weights grow with its
    // inverse.
    constexpr float kMin = 0.05f;
    const float other = std::max(kMin, RescatteredByDielectric(facets_, w));
    const float reflection = Any(sides, Lobes::Reflection) ? fresnel : fresnel * other;
    const float transmission = Any(sides, Lobes::Transmission) ? 1 - fresnel : (1 - fresnel) * other;
    return reflection / (reflection + transmission);
}

template <MicrofacetDistribution Distribution>
std::optional<BxDFSample> MultiscatterDielectricBxDF<Distribution>::Sample(Vec3 wo, const BxDFRandom& u,
                                                                           const BxDFContext& context) const {
    if (wo.z == 0 || !Any(context.sides, Lobes::BothSides)) return std::nullopt;
    Rng& rng = *context.rng;
    Walk walk = StartAt(wo);
    float weight = 1;
    for (int event = 1; walk.depth.Fly(walk.ray, rng); ++event) {
        if (event > maxEvents_) return std::nullopt;
        const Vec3 w = -walk.ray.d;
        const Vec3 wm = event > 1                 ? SampleFacet(facets_, w, rng)
                        : context.allowsRejection ? facets_.SampleVisible(w, u.direction, rng)
                                                  : facets_.SampleVisible(w, u.direction);
        const float fresnel = FresnelDielectric(Dot(w, wm), IndexAcross(walk.side));
        const float p = event > 1 ? fresnel : ReflectionProbability(fresnel, w, context.sides);
        const bool isReflected = (event > 1 ? rng.Uniform() : u.lobe) < p;
        if (event == 1) weight = isReflected ? fresnel / p : (1 - fresnel) / (1 - p);
        if (!TurnAt(wm, isReflected, walk)) return std::nullopt;
    }

    const Vec3 wi = walk.side * walk.ray.d;
    const bool isReflection = SameHemisphere(wo, wi);
    if (wi.z == 0 || !Any(context.sides, isReflection ? Lobes::Reflection : Lobes::Transmission))
        return std::nullopt;
    const float etap = isReflection ? 1 : IndexAcross(SideOf(wo));
    if (context.mode == TransportMode::Radiance) weight /= Sqr(etap);
    const SingleEvent single = SingleEventOf(wo, wi);
    return BxDFSample{.wi = wi,
                      .weight = SampledSpectrum(weight),
                      .pdf = DensityOf(single.f, wo, wi),
                      .pdfReverse = DensityOf(single.fReverse, wi, wo),
                      .lobe = isReflection ? Lobes::GlossyReflection : Lobes::GlossyTransmission,
                      .eta = etap,
                      .pdfExact = false};
}

template <MicrofacetDistribution Distribution>
void MultiscatterDielectricBxDF<Distribution>::Regularize() {
    *this = MultiscatterDielectricBxDF(Alphas(facets_.AlphaX(), facets_.AlphaY()).Regularized(), eta_,
                                       maxEvents_);
}

template class MultiscatterDielectricBxDF<TrowbridgeReitz>;
template class MultiscatterDielectricBxDF<Beckmann>;
static_assert(std::is_trivially_destructible_v<MultiscatterDielectricBxDF<TrowbridgeReitz>> &&
              std::is_trivially_destructible_v<MultiscatterDielectricBxDF<Beckmann>>);

}  // namespace lacquer
