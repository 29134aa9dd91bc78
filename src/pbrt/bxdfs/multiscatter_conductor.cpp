#include "pbrt/bxdfs/multiscatter_conductor.h"

#include <type_traits>
#include <utility>

namespace lacquer {

template <MicrofacetDistribution Distribution, class Metal>
float MultiscatterConductorBxDFOf<Distribution, Metal>::DensityOf(float single, Vec3 wo, Vec3 wi) const {
    return (single + RescatteredByMetal(facets_, wo) * InvPi) * std::abs(wi.z);
}

template <MicrofacetDistribution Distribution, class Metal>
BxDFValue MultiscatterConductorBxDFOf<Distribution, Metal>::Evaluate(Vec3 wo, Vec3 wi,
                                                                     const BxDFContext& context) const {
    if (!SameHemisphere(wo, wi) || !Any(context.sides, Lobes::Reflection)) return {};
    // Both sides reflect alike; the facets are the same ones for -wo and -wi.
    if (wo.z < 0) {
        wo = -wo;
        wi = -wi;
    }
    const MicrofacetTerms terms = ReflectionTerms(facets_, wo, wi);
    BxDFValue value{Fresnel(AbsDot(wo, terms.wm)) * terms.value};
    if (context.needsPdf) {
        value.pdf = DensityOf(terms.value, wo, wi);
        value.pdfReverse = DensityOf(terms.value, wi, wo);
    }
    value.f += EstimateRescattered(wo, wi, *context.rng);
    return value;
}

template <MicrofacetDistribution Distribution, class Metal>
float MultiscatterConductorBxDFOf<Distribution, Metal>::Pdf(Vec3 wo, Vec3 wi,
                                                            const BxDFContext& context) const {
    if (!SameHemisphere(wo, wi) || !Any(context.sides, Lobes::Reflection)) return 0;
    return DensityOf(ReflectionTerms(facets_, wo, wi).value, wo, wi);
}

template <MicrofacetDistribution Distribution, class Metal>
SampledSpectrum MultiscatterConductorBxDFOf<Distribution, Metal>::EstimateRescattered(Vec3 wo, Vec3 wi,
                                                                                      Rng& rng) const {
    // Start at either end: f is symmetric.
    if (rng.Uniform() < 0.5f) std::swap(wo, wi);
    const MicroRay outgoing(facets_, wi);
    MicroRay ray(facets_, -wo);
    DepthFreePath path(ray);
    SampledSpectrum sum(0), throughput(1);
    // Density of the directions drawn from this end over that from the other one, but for the last facet.
    float ratio = 1;
    for (int bounce = 1; bounce <= maxBounces_ && ray.areas.back > 0; ++bounce) {
        const Vec3 w = -ray.d;
        if (bounce > 1) {
            // Connect: reflect towards wi at the facet that does.
            const Vec3 half = w + wi;
            const float length2 = LengthSquared(half);
            if (half.z > 0 && length2 > 0) {
                const Vec3 wm = half / std::sqrt(length2);
                const float density = 0.25f * facets_.D(wm), back = density / outgoing.areas.front;
                if (density > 0) {
                    const float weight = 2 * ratio / (ratio + back);
                    const float escape = path.EscapeOverCosine(outgoing);
                    sum += throughput * Fresnel(AbsDot(w, wm)) * (weight * escape * density / ray.areas.back);
                }
            }
        }
        if (bounce == maxBounces_) break;

        // Go on from a facet that is seen.
        const Vec3 wm = SampleFacet(facets_, w, rng);
        const MicroRay next(facets_, Normalize(Reflect(w, wm)));
        throughput *= Fresnel(AbsDot(w, wm));
        ratio *= bounce == 1 ? 0.25f * facets_.D(wm) / ray.areas.back : next.areas.front / ray.areas.back;
        ratio = std::min(ratio, 1e30f);
        // The walk ends by the chance that it has left; the depth-free weights contain that chance.
        const float before = path.Survival();
        path.Append(next);
        if (!(rng.Uniform() * before < path.Survival())) break;
        throughput *= before / path.Survival();
        ray = next;
    }
    return sum;
}

template <MicrofacetDistribution Distribution, class Metal>
std::optional<BxDFSample> MultiscatterConductorBxDFOf<Distribution, Metal>::Sample(
    Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const {
    if (wo.z == 0 || !Any(context.sides, Lobes::Reflection)) return std::nullopt;
    const float side = wo.z > 0 ? 1.f : -1.f;
    Rng& rng = *context.rng;
    MicroRay ray(facets_, -side * wo);
    MicroDepth depth;
    SampledSpectrum weight(1);
    for (int bounce = 1; depth.Fly(ray, rng); ++bounce) {
        if (bounce > maxBounces_) return std::nullopt;
        const Vec3 w = -ray.d;
        const Vec3 wm = bounce > 1                ? SampleFacet(facets_, w, rng)
                        : context.allowsRejection ? facets_.SampleVisible(w, u.direction, rng)
                                                  : facets_.SampleVisible(w, u.direction);
        weight *= Fresnel(AbsDot(w, wm));
        ray = MicroRay(facets_, Normalize(Reflect(w, wm)));
    }
    const Vec3 wi = side * ray.d;
    if (wi.z == 0) return std::nullopt;
    const float single = ReflectionTerms(facets_, wo, wi).value;
    return BxDFSample{.wi = wi,
                      .weight = weight,
                      .pdf = DensityOf(single, wo, wi),
                      .pdfReverse = DensityOf(single, wi, wo),
                      .lobe = Lobes::GlossyReflection,
                      .pdfExact = false};
}

template <MicrofacetDistribution Distribution, class Metal>
void MultiscatterConductorBxDFOf<Distribution, Metal>::Regularize() {
    *this = MultiscatterConductorBxDFOf(Alphas(facets_.AlphaX(), facets_.AlphaY()).Regularized(), metal_,
                                        maxBounces_);
}

template class MultiscatterConductorBxDFOf<TrowbridgeReitz, TintedMetal>;
template class MultiscatterConductorBxDFOf<TrowbridgeReitz, BareMetal>;
template class MultiscatterConductorBxDFOf<Beckmann, BareMetal>;
template class MultiscatterConductorBxDFOf<TrowbridgeReitz, FilmedMetal>;
template class MultiscatterConductorBxDFOf<Beckmann, FilmedMetal>;
static_assert(std::is_trivially_destructible_v<MultiscatterConductorBxDF<TrowbridgeReitz>> &&
              std::is_trivially_destructible_v<FilmedMultiscatterConductorBxDF<Beckmann>>);

}  // namespace lacquer
