#include "pbrt/bxdfs/dielectric.h"

#include <type_traits>

namespace lacquer {

template <MicrofacetDistribution Distribution, class Boundary>
Lobes DielectricBxDFOf<Distribution, Boundary>::Flags() const {
    if (Boundary::kIsBare && boundary_.Eta() == 1) return Lobes::SpecularTransmission;
    return Lobes::BothSides | (isSpecular_ ? Lobes::Specular : Lobes::Glossy);
}

template <MicrofacetDistribution Distribution, class Boundary>
auto DielectricBxDFOf<Distribution, Boundary>::ProbabilitiesOf(float share, Lobes sides)
    -> SideProbabilities {
    const bool reflects = Any(sides, Lobes::Reflection), transmits = Any(sides, Lobes::Transmission);
    if (reflects && transmits) return {share, 1 - share};
    return {reflects && share > 0 ? 1.f : 0.f, transmits && share < 1 ? 1.f : 0.f};
}

// Radiance shrinks by etap^2 where it passes to the side of wi seen from wo: a beam spreads over a larger
// solid angle on the side of the smaller index [Veach 1997, sec. 5.2]. Importance does not.
template <MicrofacetDistribution Distribution, class Boundary>
BxDFValue DielectricBxDFOf<Distribution, Boundary>::Evaluate(Vec3 wo, Vec3 wi,
                                                             const BxDFContext& context) const {
    if (isSpecular_ || wo.z == 0 || wi.z == 0) return {};
    if (SameHemisphere(wo, wi)) {
        if (!Any(context.sides, Lobes::Reflection)) return {};
        const MicrofacetTerms terms = ReflectionTerms(facets_, wo, wi);
        const auto shares = boundary_.At(Dot(wo, terms.wm));
        const float probability =
            ProbabilitiesOf(Boundary::ReflectionShare(shares), context.sides).reflection;
        return {SampledSpectrum(shares.reflected * terms.value), probability * terms.pdf,
                probability * terms.pdfReverse};
    }
    if (!Any(context.sides, Lobes::Transmission)) return {};
    const float etap = IndexAcross(wo);
    const MicrofacetTerms terms = TransmissionTerms(facets_, wo, wi, etap);
    const auto shares = boundary_.At(Dot(wo, terms.wm));
    const float probability = ProbabilitiesOf(Boundary::ReflectionShare(shares), context.sides).transmission;
    const float scale = context.mode == TransportMode::Radiance ? 1 / (etap * etap) : 1.f;
    return {SampledSpectrum(shares.transmitted * terms.value * scale), probability * terms.pdf,
            probability * terms.pdfReverse};
}

template <MicrofacetDistribution Distribution, class Boundary>
std::optional<BxDFSample> DielectricBxDFOf<Distribution, Boundary>::SampleSpecular(
    Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const {
    // Choose a side.
    const auto shares = boundary_.At(CosTheta(wo));
    const SideProbabilities p = ProbabilitiesOf(Boundary::ReflectionShare(shares), context.sides);
    if (u.lobe < p.reflection)
        return BxDFSample{.wi = {-wo.x, -wo.y, wo.z},
                          .weight = SampledSpectrum(shares.reflected / p.reflection),
                          .pdf = p.reflection,
                          .pdfReverse = p.reflection,
                          .lobe = Lobes::SpecularReflection};
    if (!(p.transmission > 0)) return std::nullopt;

    // Pass through, bent or not.
    const std::optional<Refraction> refracted =
        boundary_.Eta() == 1 ? Refraction{-wo, 1} : Refract(wo, {0, 0, 1}, boundary_.Eta());
    if (!refracted || SameHemisphere(wo, refracted->w) || refracted->w.z == 0) return std::nullopt;
    const float scale = context.mode == TransportMode::Radiance ? 1 / Sqr(refracted->eta) : 1.f;
    return BxDFSample{.wi = refracted->w,
                      .weight = SampledSpectrum(shares.transmitted / p.transmission * scale),
                      .pdf = p.transmission,
                      // A beam's solid angle times its cosine shrinks by eta^2.
                      .pdfReverse = p.transmission * std::abs(wo.z / (Sqr(refracted->eta) * refracted->w.z)),
                      .lobe = Lobes::SpecularTransmission,
                      .eta = refracted->eta};
}

template <MicrofacetDistribution Distribution, class Boundary>
inline Vec3 DielectricBxDFOf<Distribution, Boundary>::SampleFacet(Vec3 wo, const BxDFRandom& u,
                                                                  const BxDFContext& context) const {
    const Vec3 w = wo.z < 0 ? -wo : wo;
    return context.allowsRejection ? facets_.SampleVisible(w, u.direction, *context.rng)
                                   : facets_.SampleVisible(w, u.direction);
}

template <MicrofacetDistribution Distribution, class Boundary>
std::optional<BxDFSample> DielectricBxDFOf<Distribution, Boundary>::Sample(Vec3 wo, const BxDFRandom& u,
                                                                           const BxDFContext& context) const {
    if (wo.z == 0) return std::nullopt;
    if (isSpecular_) return SampleSpecular(wo, u, context);
    // Draw a facet, then one of its two directions.
    const Vec3 wm = SampleFacet(wo, u, context);
    if (!context.needsSamplePdf) return SampleWithoutPdf(wo, wm, u.lobe, context);
    // Where only one side is asked for, its probability does not depend on its share.
    const float share =
        context.sides == Lobes::BothSides ? Boundary::ReflectionShare(boundary_.At(Dot(wo, wm))) : 0.5f;
    const SideProbabilities p = ProbabilitiesOf(share, context.sides);
    if (u.lobe < p.reflection) return SampleReflection(wo, Normalize(Reflect(wo, wm)), context);
    if (!(p.transmission > 0)) return std::nullopt;
    const std::optional<Refraction> refracted = Refract(wo, wm, boundary_.Eta());
    if (!refracted) return std::nullopt;
    return SampleTransmission(wo, Normalize(refracted->w), context);
}

// Of the terms, shadowing alone is left.
template <MicrofacetDistribution Distribution, class Boundary>
inline std::optional<BxDFSample> DielectricBxDFOf<Distribution, Boundary>::SampleWithoutPdf(
    Vec3 wo, Vec3 wm, float uLobe, const BxDFContext& context) const {
    const auto shares = boundary_.At(Dot(wo, wm));
    const SideProbabilities p = ProbabilitiesOf(Boundary::ReflectionShare(shares), context.sides);
    BxDFSample sample;
    sample.pdfExact = false;
    if (uLobe < p.reflection) {
        sample.wi = Normalize(Reflect(wo, wm));
        if (!SameHemisphere(wo, sample.wi)) return std::nullopt;
        sample.weight = SampledSpectrum(shares.reflected / p.reflection);
        sample.lobe = Lobes::GlossyReflection;
    } else {
        if (!(p.transmission > 0)) return std::nullopt;
        const std::optional<Refraction> refracted = Refract(wo, wm, boundary_.Eta());
        if (!refracted) return std::nullopt;
        sample.wi = Normalize(refracted->w);
        if (SameHemisphere(wo, sample.wi) || sample.wi.z == 0) return std::nullopt;
        sample.eta = IndexAcross(wo);
        const float scale = context.mode == TransportMode::Radiance ? 1 / Sqr(sample.eta) : 1.f;
        sample.weight = SampledSpectrum(shares.transmitted / p.transmission * scale);
        sample.lobe = Lobes::GlossyTransmission;
    }
    sample.weight *= Shadowing<Distribution>(facets_, wo, sample.wi).ratio;
    return sample;
}

// In both, the density is that of wi as it was rounded, so that it is the one that Evaluate() finds.
template <MicrofacetDistribution Distribution, class Boundary>
inline std::optional<BxDFSample> DielectricBxDFOf<Distribution, Boundary>::SampleReflection(
    Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    if (!SameHemisphere(wo, wi)) return std::nullopt;
    const MicrofacetTerms terms = ReflectionTerms(facets_, wo, wi);
    const auto shares = boundary_.At(Dot(wo, terms.wm));
    const float probability = ProbabilitiesOf(Boundary::ReflectionShare(shares), context.sides).reflection;
    const float pdf = probability * terms.pdf;
    if (!(pdf > 0)) return std::nullopt;
    return BxDFSample{.wi = wi,
                      .weight = SampledSpectrum(shares.reflected / probability * terms.shadowingRatio),
                      .pdf = pdf,
                      .pdfReverse = probability * terms.pdfReverse,
                      .lobe = Lobes::GlossyReflection};
}

template <MicrofacetDistribution Distribution, class Boundary>
inline std::optional<BxDFSample> DielectricBxDFOf<Distribution, Boundary>::SampleTransmission(
    Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    if (SameHemisphere(wo, wi) || wi.z == 0) return std::nullopt;
    const float etap = IndexAcross(wo);
    const MicrofacetTerms terms = TransmissionTerms(facets_, wo, wi, etap);
    const auto shares = boundary_.At(Dot(wo, terms.wm));
    const float probability = ProbabilitiesOf(Boundary::ReflectionShare(shares), context.sides).transmission;
    const float pdf = probability * terms.pdf;
    if (!(pdf > 0)) return std::nullopt;
    const float scale = context.mode == TransportMode::Radiance ? 1 / (etap * etap) : 1.f;
    return BxDFSample{
        .wi = wi,
        .weight = SampledSpectrum(shares.transmitted / probability * terms.shadowingRatio * scale),
        .pdf = pdf,
        .pdfReverse = probability * terms.pdfReverse,
        .lobe = Lobes::GlossyTransmission,
        .eta = etap};
}

template <MicrofacetDistribution Distribution, class Boundary>
SurfaceModel DielectricBxDFOf<Distribution, Boundary>::Model() const {
    // What knows a boundary by its index computes with Fresnel's factor.
    if (!Boundary::kIsBare) return {};
    if (isSpecular_) return SmoothSurface{boundary_.Eta()};
    return MicrofacetSurface{kModelOf<Distribution>, facets_.AlphaX(), facets_.AlphaY(), boundary_.Eta()};
}

template <MicrofacetDistribution Distribution, class Boundary>
void DielectricBxDFOf<Distribution, Boundary>::Regularize() {
    *this = DielectricBxDFOf(Alphas(facets_.AlphaX(), facets_.AlphaY()).Regularized(), boundary_);
}

template class DielectricBxDFOf<TrowbridgeReitz, BareDielectric>;
template class DielectricBxDFOf<Beckmann, BareDielectric>;
template class DielectricBxDFOf<TrowbridgeReitz, FilmedDielectric>;
template class DielectricBxDFOf<Beckmann, FilmedDielectric>;
template class DielectricBxDFOf<TrowbridgeReitz, TintedDielectric>;
static_assert(std::is_trivially_destructible_v<DielectricBxDF<TrowbridgeReitz>> &&
              std::is_trivially_destructible_v<FilmedDielectricBxDF<Beckmann>>);

}  // namespace lacquer
