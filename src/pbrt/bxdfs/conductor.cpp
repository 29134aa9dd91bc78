#include "pbrt/bxdfs/conductor.h"

#include <type_traits>

namespace lacquer {

template <MicrofacetDistribution Distribution>
BxDFValue ConductorBxDF<Distribution>::Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    if (isSmooth_ || !SameHemisphere(wo, wi) || !Any(context.sides, Lobes::Reflection)) return {};
    const MicrofacetTerms terms = ReflectionTerms(facets_, wo, wi);
    return {FresnelConductor(AbsDot(wo, terms.wm), eta_, k_) * terms.value, terms.pdf, terms.pdfReverse};
}

template <MicrofacetDistribution Distribution>
inline Vec3 ConductorBxDF<Distribution>::SampleFacet(Vec3 wo, const BxDFRandom& u,
                                                     const BxDFContext& context) const {
    const Vec3 w = wo.z < 0 ? -wo : wo;
    return context.allowsRejection ? facets_.SampleVisible(w, u.direction, *context.rng)
                                   : facets_.SampleVisible(w, u.direction);
}

template <MicrofacetDistribution Distribution>
std::optional<BxDFSample> ConductorBxDF<Distribution>::Sample(Vec3 wo, const BxDFRandom& u,
                                                              const BxDFContext& context) const {
    if (wo.z == 0 || !Any(context.sides, Lobes::Reflection)) return std::nullopt;
    if (isSmooth_)
        return BxDFSample{.wi = {-wo.x, -wo.y, wo.z},
                          .weight = FresnelConductor(AbsCosTheta(wo), eta_, k_),
                          .pdf = 1,
                          .pdfReverse = 1,
                          .lobe = Lobes::SpecularReflection};

    const Vec3 wi = Normalize(Reflect(wo, SampleFacet(wo, u, context)));
    if (!SameHemisphere(wo, wi)) return std::nullopt;
    // The density is that of wi as it was rounded, so that it is the one that Evaluate() finds.
    const MicrofacetTerms terms = ReflectionTerms(facets_, wo, wi);
    if (!(terms.pdf > 0)) return std::nullopt;
    return BxDFSample{.wi = wi,
                      .weight = FresnelConductor(AbsDot(wo, terms.wm), eta_, k_) * terms.shadowingRatio,
                      .pdf = terms.pdf,
                      .pdfReverse = terms.pdfReverse,
                      .lobe = Lobes::GlossyReflection};
}

template <MicrofacetDistribution Distribution>
SurfaceModel ConductorBxDF<Distribution>::Model() const {
    if (isSmooth_) return {};
    return MicrofacetSurface{kModelOf<Distribution>, facets_.AlphaX(), facets_.AlphaY(), 0};
}

template <MicrofacetDistribution Distribution>
void ConductorBxDF<Distribution>::Regularize() {
    *this = ConductorBxDF(Alphas(facets_.AlphaX(), facets_.AlphaY()).Regularized(), eta_, k_);
}

template class ConductorBxDF<TrowbridgeReitz>;
template class ConductorBxDF<Beckmann>;
static_assert(std::is_trivially_destructible_v<ConductorBxDF<TrowbridgeReitz>> &&
              std::is_trivially_destructible_v<ConductorBxDF<Beckmann>>);

}  // namespace lacquer
