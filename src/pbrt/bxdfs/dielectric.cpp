#include "pbrt/bxdfs/dielectric.h"

#include <type_traits>

namespace lacquer {

template <MicrofacetDistribution Distribution>
Lobes DielectricBxDF<Distribution>::Flags() const {
    if (eta_ == 1) return Lobes::SpecularTransmission;
    return Lobes::BothSides | (isSpecular_ ? Lobes::Specular : Lobes::Glossy);
}

template <MicrofacetDistribution Distribution>
auto DielectricBxDF<Distribution>::ProbabilitiesOf(float fresnel, Lobes sides) -> SideProbabilities {
    const bool reflects = Any(sides, Lobes::Reflection), transmits = Any(sides, Lobes::Transmission);
    if (reflects && transmits) return {fresnel, 1 - fresnel};
    return {reflects && fresnel > 0 ? 1.f : 0.f, transmits && fresnel < 1 ? 1.f : 0.f};
}

// Radiance shrinks by etap^2 where it passes to the side of wi seen from wo: a beam spreads over a larger
// solid angle on the side of the smaller index [Veach 1997, sec. 5.2]. Importance does not.
template <MicrofacetDistribution Distribution>
BxDFValue DielectricBxDF<Distribution>::Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    if (isSpecular_ || wo.z == 0 || wi.z == 0) return {};
    if (SameHemisphere(wo, wi)) {
        if (!Any(context.sides, Lobes::Reflection)) return {};
        const MicrofacetTerms terms = ReflectionTerms(facets_, wo, wi);
        const float fresnel = FresnelDielectric(Dot(wo, terms.wm), eta_);
        const float probability = ProbabilitiesOf(fresnel, context.sides).reflection;
        return {SampledSpectrum(fresnel * terms.value), probability * terms.pdf,
                probability * terms.pdfReverse};
    }
    if (!Any(context.sides, Lobes::Transmission)) return {};
    const float etap = IndexAcross(wo);
    const MicrofacetTerms terms = TransmissionTerms(facets_, wo, wi, etap);
    const float fresnel = FresnelDielectric(Dot(wo, terms.wm), eta_);
    const float probability = ProbabilitiesOf(fresnel, context.sides).transmission;
    const float scale = context.mode == TransportMode::Radiance ? 1 / (etap * etap) : 1.f;
    return {SampledSpectrum((1 - fresnel) * terms.value * scale), probability * terms.pdf,
            probability * terms.pdfReverse};
}

template <MicrofacetDistribution Distribution>
std::optional<BxDFSample> DielectricBxDF<Distribution>::SampleSpecular(Vec3 wo, const BxDFRandom& u,
                                                                       const BxDFContext& context) const {
    // Choose a side.
    const float fresnel = eta_ == 1 ? 0.f : FresnelDielectric(CosTheta(wo), eta_);
    const SideProbabilities p = ProbabilitiesOf(fresnel, context.sides);
    if (u.lobe < p.reflection)
        return BxDFSample{.wi = {-wo.x, -wo.y, wo.z},
                          .weight = SampledSpectrum(fresnel / p.reflection),
                          .pdf = p.reflection,
                          .pdfReverse = p.reflection,
                          .lobe = Lobes::SpecularReflection};
    if (!(p.transmission > 0)) return std::nullopt;

    // Pass through, bent or not.
    const std::optional<Refraction> refracted = eta_ == 1 ? Refraction{-wo, 1} : Refract(wo, {0, 0, 1}, eta_);
    if (!refracted || SameHemisphere(wo, refracted->w) || refracted->w.z == 0) return std::nullopt;
    const float scale = context.mode == TransportMode::Radiance ? 1 / Sqr(refracted->eta) : 1.f;
    return BxDFSample{.wi = refracted->w,
                      .weight = SampledSpectrum((1 - fresnel) / p.transmission * scale),
                      .pdf = p.transmission,
                      // A beam's solid angle times its cosine shrinks by eta^2.
                      .pdfReverse = p.transmission * std::abs(wo.z / (Sqr(refracted->eta) * refracted->w.z)),
                      .lobe = Lobes::SpecularTransmission,
                      .eta = refracted->eta};
}

template <MicrofacetDistribution Distribution>
inline Vec3 DielectricBxDF<Distribution>::SampleFacet(Vec3 wo, const BxDFRandom& u,
                                                      const BxDFContext& context) const {
    const Vec3 w = wo.z < 0 ? -wo : wo;
    return context.allowsRejection ? facets_.SampleVisible(w, u.direction, *context.rng)
                                   : facets_.SampleVisible(w, u.direction);
}

template <MicrofacetDistribution Distribution>
std::optional<BxDFSample> DielectricBxDF<Distribution>::Sample(Vec3 wo, const BxDFRandom& u,
                                                               const BxDFContext& context) const {
    if (wo.z == 0) return std::nullopt;
    if (isSpecular_) return SampleSpecular(wo, u, context);
    // Draw a facet, then one of its two directions.
    const Vec3 wm = SampleFacet(wo, u, context);
    // Where only one side is asked for, its probability does not depend on Fresnel's factor.
    const float fresnel = context.sides == Lobes::BothSides ? FresnelDielectric(Dot(wo, wm), eta_) : 0.5f;
    const SideProbabilities p = ProbabilitiesOf(fresnel, context.sides);
    if (u.lobe < p.reflection) return SampleReflection(wo, Normalize(Reflect(wo, wm)), context);
    if (!(p.transmission > 0)) return std::nullopt;
    const std::optional<Refraction> refracted = Refract(wo, wm, eta_);
    if (!refracted) return std::nullopt;
    return SampleTransmission(wo, Normalize(refracted->w), context);
}

// In both, the density is that of wi as it was rounded, so that it is the one that Evaluate() finds.
template <MicrofacetDistribution Distribution>
inline std::optional<BxDFSample> DielectricBxDF<Distribution>::SampleReflection(
    Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    if (!SameHemisphere(wo, wi)) return std::nullopt;
    const MicrofacetTerms terms = ReflectionTerms(facets_, wo, wi);
    const float fresnel = FresnelDielectric(Dot(wo, terms.wm), eta_);
    const float probability = ProbabilitiesOf(fresnel, context.sides).reflection;
    const float pdf = probability * terms.pdf;
    if (!(pdf > 0)) return std::nullopt;
    return BxDFSample{.wi = wi,
                      .weight = SampledSpectrum(fresnel / probability * terms.shadowingRatio),
                      .pdf = pdf,
                      .pdfReverse = probability * terms.pdfReverse,
                      .lobe = Lobes::GlossyReflection};
}

template <MicrofacetDistribution Distribution>
inline std::optional<BxDFSample> DielectricBxDF<Distribution>::SampleTransmission(
    Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    if (SameHemisphere(wo, wi) || wi.z == 0) return std::nullopt;
    const float etap = IndexAcross(wo);
    const MicrofacetTerms terms = TransmissionTerms(facets_, wo, wi, etap);
    const float fresnel = FresnelDielectric(Dot(wo, terms.wm), eta_);
    const float probability = ProbabilitiesOf(fresnel, context.sides).transmission;
    const float pdf = probability * terms.pdf;
    if (!(pdf > 0)) return std::nullopt;
    const float scale = context.mode == TransportMode::Radiance ? 1 / (etap * etap) : 1.f;
    return BxDFSample{.wi = wi,
                      .weight = SampledSpectrum((1 - fresnel) / probability * terms.shadowingRatio * scale),
                      .pdf = pdf,
                      .pdfReverse = probability * terms.pdfReverse,
                      .lobe = Lobes::GlossyTransmission,
                      .eta = etap};
}

template <MicrofacetDistribution Distribution>
SurfaceModel DielectricBxDF<Distribution>::Model() const {
    if (isSpecular_) return SmoothSurface{eta_};
    return MicrofacetSurface{kModelOf<Distribution>, facets_.AlphaX(), facets_.AlphaY(), eta_};
}

template <MicrofacetDistribution Distribution>
void DielectricBxDF<Distribution>::Regularize() {
    *this = DielectricBxDF(Alphas(facets_.AlphaX(), facets_.AlphaY()).Regularized(), eta_);
}

template class DielectricBxDF<TrowbridgeReitz>;
template class DielectricBxDF<Beckmann>;
static_assert(std::is_trivially_destructible_v<DielectricBxDF<TrowbridgeReitz>> &&
              std::is_trivially_destructible_v<DielectricBxDF<Beckmann>>);

}  // namespace lacquer
