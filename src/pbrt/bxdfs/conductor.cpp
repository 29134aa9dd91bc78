#include "pbrt/bxdfs/conductor.h"

#include <type_traits>

namespace lacquer {

template <MicrofacetDistribution Distribution, class Metal>
BxDFValue ConductorBxDFOf<Distribution, Metal>::Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    if (isSmooth_ || !SameHemisphere(wo, wi) || !Any(context.sides, Lobes::Reflection)) return {};
    const MicrofacetTerms terms = ReflectionTerms(facets_, wo, wi);
    return {metal_.Reflectance(AbsDot(wo, terms.wm)) * terms.value, terms.pdf, terms.pdfReverse};
}

template <MicrofacetDistribution Distribution, class Metal>
inline Vec3 ConductorBxDFOf<Distribution, Metal>::SampleFacet(Vec3 wo, const BxDFRandom& u,
                                                              const BxDFContext& context) const {
    const Vec3 w = wo.z < 0 ? -wo : wo;
    return context.allowsRejection ? facets_.SampleVisible(w, u.direction, *context.rng)
                                   : facets_.SampleVisible(w, u.direction);
}

template <MicrofacetDistribution Distribution, class Metal>
std::optional<BxDFSample> ConductorBxDFOf<Distribution, Metal>::Sample(Vec3 wo, const BxDFRandom& u,
                                                                       const BxDFContext& context) const {
    if (wo.z == 0 || !Any(context.sides, Lobes::Reflection)) return std::nullopt;
    if (isSmooth_)
        return BxDFSample{.wi = {-wo.x, -wo.y, wo.z},
                          .weight = metal_.Reflectance(AbsCosTheta(wo)),
                          .pdf = 1,
                          .pdfReverse = 1,
                          .lobe = Lobes::SpecularReflection};

    const Vec3 wm = SampleFacet(wo, u, context), wi = Normalize(Reflect(wo, wm));
    if (!SameHemisphere(wo, wi)) return std::nullopt;
    if (!context.needsSamplePdf)
        return BxDFSample{
            .wi = wi,
            .weight = metal_.Reflectance(AbsDot(wo, wm)) * Shadowing<Distribution>(facets_, wo, wi).ratio,
            .lobe = Lobes::GlossyReflection,
            .pdfExact = false};
    // The density is that of wi as it was rounded, so that it is the one that Evaluate() finds.
    const MicrofacetTerms terms = ReflectionTerms(facets_, wo, wi);
    if (!(terms.pdf > 0)) return std::nullopt;
    return BxDFSample{.wi = wi,
                      .weight = metal_.Reflectance(AbsDot(wo, terms.wm)) * terms.shadowingRatio,
                      .pdf = terms.pdf,
                      .pdfReverse = terms.pdfReverse,
                      .lobe = Lobes::GlossyReflection};
}

template <MicrofacetDistribution Distribution, class Metal>
SurfaceModel ConductorBxDFOf<Distribution, Metal>::Model() const {
    if (isSmooth_) return {};
    return MicrofacetSurface{kModelOf<Distribution>, facets_.AlphaX(), facets_.AlphaY(), 0};
}

template <MicrofacetDistribution Distribution, class Metal>
void ConductorBxDFOf<Distribution, Metal>::Regularize() {
    *this = ConductorBxDFOf(Alphas(facets_.AlphaX(), facets_.AlphaY()).Regularized(), metal_);
}

template class ConductorBxDFOf<TrowbridgeReitz, BareMetal>;
template class ConductorBxDFOf<Beckmann, BareMetal>;
template class ConductorBxDFOf<TrowbridgeReitz, FilmedMetal>;
template class ConductorBxDFOf<Beckmann, FilmedMetal>;
template class ConductorBxDFOf<TrowbridgeReitz, TintedMetal>;
static_assert(std::is_trivially_destructible_v<ConductorBxDF<TrowbridgeReitz>> &&
              std::is_trivially_destructible_v<FilmedConductorBxDF<Beckmann>>);

}  // namespace lacquer
