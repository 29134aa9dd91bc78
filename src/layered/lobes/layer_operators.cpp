#include "layered/lobes/layer_operators.h"

#include "layered/lobes/facet_albedo.h"

namespace lacquer::layered {

float SpreadOf(MicrofacetModel model, float alpha) {
    if (model == MicrofacetModel::Beckmann) return alpha * alpha;
    const float power = std::pow(std::min(alpha, 0.999f), 1.1f);
    return power / (1 - power);
}

float AlphaOf(MicrofacetModel model, float spread) {
    if (model == MicrofacetModel::Beckmann) return std::min(std::sqrt(spread), 1.f);
    return std::pow(spread / (1 + spread), 1 / 1.1f);
}

namespace {

Vec3 DirectionAt(float cosTheta, bool isAbove) {
    const Vec3 w{SafeSqrt(1 - cosTheta * cosTheta), 0, cosTheta};
    return isAbove ? w : -w;
}

/// By the records of either side.
InterfaceOperators SpecularOperators(const StackInterface& interface, Vec3 w, Rng* rng) {
    InterfaceOperators result;
    const BxDFContext context{TransportMode::Importance, Lobes::BothSides, rng};
    // The smallest number of all chooses reflection where there is any, the largest one transmission.
    if (const auto s = interface.Sample(w, {0, Point2(0.5f)}, context); s && s->IsReflection())
        result.reflected = s->weight * s->pdf;
    const auto s = interface.Sample(w, {OneMinusEpsilon, Point2(0.5f)}, context);
    if (!s || !s->IsTransmission()) return result;
    result.transmitted = s->weight * s->pdf;
    result.eta = s->eta;
    return result;
}

/// The reflectance of metal, about: its f at the mirror direction without the facets' part.
template <MicrofacetDistribution Distribution>
SampledSpectrum MirrorReflectance(const StackInterface& interface, float alpha, Vec3 w,
                                  const BxDFContext& context) {
    const Vec3 mirrored{-w.x, -w.y, w.z};
    const float facets = ReflectionTerms(Distribution(alpha, alpha), w, mirrored).value;
    const SampledSpectrum f = interface.bxdf->Evaluate(w, mirrored, context).f;
    return facets > 0 ? Min(f / facets, SampledSpectrum(1)) : SampledSpectrum(0);
}

InterfaceOperators RoughOperators(const StackInterface& interface, const MicrofacetSurface& surface,
                                  bool isFromAbove, float cosTheta, float alphaBeam, Rng* rng) {
    InterfaceOperators result;
    result.alpha = std::sqrt(0.5f * (Sqr(surface.alphaX) + Sqr(surface.alphaY)));
    const float alpha = std::sqrt(Sqr(result.alpha) + Sqr(alphaBeam));
    if (surface.eta > 0) {
        result.eta = isFromAbove ? surface.eta : 1 / surface.eta;
        const FacetAlbedo albedo = IntegrateFacets(surface.model, alpha, result.eta, cosTheta, result.alpha);
        result.reflected = SampledSpectrum(albedo.reflected);
        result.transmitted = SampledSpectrum(albedo.transmitted);
        return result;
    }
    if (surface.alphaX != surface.alphaY) {
        // Fresnel's factor of another direction on facets of the mean alpha would be no better.
        const Vec3 up{0, 0, isFromAbove ? 1.f : -1.f};
        const BxDFContext context{TransportMode::Radiance, Lobes::BothSides, rng};
        const float facets = InvPi / (4 * surface.alphaX * surface.alphaY);
        result.reflected = Min(interface.bxdf->Evaluate(up, up, context).f / facets, SampledSpectrum(1));
    } else {
        const Vec3 w = DirectionAt(cosTheta, isFromAbove);
        const BxDFContext context{TransportMode::Radiance, Lobes::BothSides, rng};
        result.reflected = surface.model == MicrofacetModel::Beckmann
                               ? MirrorReflectance<Beckmann>(interface, surface.alphaX, w, context)
                               : MirrorReflectance<TrowbridgeReitz>(interface, surface.alphaX, w, context);
    }
    result.reflected *= IntegrateFacets(surface.model, alpha, 0, cosTheta, result.alpha).reflected;
    return result;
}

/// A boundary of smooth media in a wide beam.
InterfaceOperators SmoothInWideBeam(const SmoothSurface& surface, bool isFromAbove, float cosTheta,
                                    float alphaBeam) {
    InterfaceOperators result;
    result.eta = isFromAbove ? surface.eta : 1 / surface.eta;
    const FacetAlbedo albedo = IntegrateFacets(MicrofacetModel::Beckmann, alphaBeam, result.eta, cosTheta, 0);
    result.reflected = SampledSpectrum(1 - albedo.transmitted);
    result.transmitted = SampledSpectrum(albedo.transmitted);
    return result;
}

}  // namespace

InterfaceOperators OperatorsOf(const StackInterface& interface, bool isFromAbove, float cosTheta,
                               float alphaBeam, Rng* rng) {
    if (const auto* surface = std::get_if<MicrofacetSurface>(&interface.model))
        return RoughOperators(interface, *surface, isFromAbove, cosTheta, alphaBeam, rng);
    if (const auto* smooth = std::get_if<SmoothSurface>(&interface.model); smooth && alphaBeam > 0)
        return SmoothInWideBeam(*smooth, isFromAbove, cosTheta, alphaBeam);
    const Vec3 w = DirectionAt(cosTheta, isFromAbove);
    if (interface.isSpecular) return SpecularOperators(interface, w, rng);
    // Everything else is taken for diffuse.
    const BxDFContext context{TransportMode::Importance, Lobes::BothSides, rng};
    InterfaceOperators result;
    const Vec3 mirrored{-w.x, -w.y, w.z};
    result.diffuse = Min(interface.bxdf->Evaluate(w, mirrored, context).f * Pi, SampledSpectrum(1));
    if (interface.transmits)
        result.diffuseBeyond =
            Min(interface.bxdf->Evaluate(w, -w, context).f * Pi, SampledSpectrum(1) - result.diffuse);
    return result;
}

DiffuseOperators DiffuseOperatorsOf(const InterfaceOperators& layer) {
    // Of a cosine lobe Fresnel's factor is that of normal incidence and what grazing directions add to it,
    // and from the denser side only a cone passes; within 0.02.
    const float r = Sqr((1 - layer.eta) / (1 + layer.eta)), entering = std::max(0.95f - r, 0.f);
    const float passed = layer.eta == 1 ? 1.f : entering * std::min(Sqr(layer.eta), 1.f);
    if (layer.alpha == 0) return {passed, 1 - passed};
    // What facets shadow, at middle angles of what passes and of what does not.
    const auto left = [&](float cosTheta) {
        const FacetAlbedo albedo =
            IntegrateFacets(MicrofacetModel::TrowbridgeReitz, layer.alpha, layer.eta, cosTheta);
        return albedo.reflected + albedo.transmitted;
    };
    return {passed * left(std::sqrt(1 - 0.5f * std::min(Sqr(layer.eta), 1.f))), (1 - passed) * left(0.5f)};
}

float MeanCosineOf(const PhaseFunction& phase) {
    // (1 + g)/(1 - g)^2 = 4 pi p.
    const Vec3 w{0, 0, 1};
    const float peak = 4 * Pi * phase.Evaluate(w, -w).p;
    if (!(peak > 1)) return 0;
    return (2 * peak + 1 - std::sqrt(8 * peak + 1)) / (2 * peak);
}

SlabOperators OperatorsOf(const Slab& slab, float cosTheta) {
    SlabOperators result;
    if (slab.IsClear()) return result;
    const Vec3 w = DirectionAt(cosTheta, true);
    const SampledSpectrum straight = slab.Cross(w, 1).transmittance;
    result.transmitted = straight;
    if (!slab.Scatters()) return result;
    // At most one forward event: exp(-tau)(1 + albedo tau).
    const float path = 1 / Slab::AbsCos(w);
    const SampledSpectrum once = slab.albedo * slab.opticalThickness * path;
    result.transmitted = Min(straight * (SampledSpectrum(1) + once), SampledSpectrum(1));
    result.scattered = std::max(((SampledSpectrum(1) - result.transmitted) * slab.albedo).Average(), 0.f);
    // [Belcour 2018]: the variance of the Henyey-Greenstein lobe.
    const float g = std::max(MeanCosineOf(*slab.phase), 0.02f);
    const float part = (once / (SampledSpectrum(1) + once)).Average();
    result.spread = part * std::pow((1 - g) / g, 0.8f) / (1 + g);
    return result;
}

}  // namespace lacquer::layered
