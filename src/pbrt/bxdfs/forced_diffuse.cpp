#include "pbrt/bxdfs/forced_diffuse.h"

#include "pbrt/core/sampling.h"

namespace lacquer {

namespace {

bool Scatters(Vec3 wo, Vec3 wi, const BxDFContext& context) {
    return SameHemisphere(wo, wi) && Any(context.sides, Lobes::Reflection);
}

}  // namespace

/// An unbiased estimate of R. The direction is that of the camera's side whichever way light is traced: so f
/// is adjoint to itself.
SampledSpectrum ForcedDiffuseBxDF::DrawAlbedo(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    const Vec3 seenFrom = context.mode == TransportMode::Radiance ? wo : wi;
    const BxDFContext draw{
        .rng = context.rng, .needsPdf = false, .drawsFreely = true, .counters = context.counters};
    const float uLobe = context.rng->Uniform();
    const auto sample = model_->Sample(seenFrom, {uLobe, context.rng->Uniform2D()}, draw);
    return sample ? sample->weight : SampledSpectrum(0);
}

BxDFValue ForcedDiffuseBxDF::Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    if (!Scatters(wo, wi, context)) return {};
    return {DrawAlbedo(wo, wi, context) * InvPi, AbsCosTheta(wi) * InvPi, AbsCosTheta(wo) * InvPi};
}

float ForcedDiffuseBxDF::Pdf(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    return Scatters(wo, wi, context) ? AbsCosTheta(wi) * InvPi : 0.f;
}

std::optional<BxDFSample> ForcedDiffuseBxDF::Sample(Vec3 wo, const BxDFRandom& u,
                                                    const BxDFContext& context) const {
    if (wo.z == 0 || !Any(context.sides, Lobes::Reflection)) return std::nullopt;
    Vec3 wi = SampleCosineHemisphere(u.direction);
    if (wi.z == 0) return std::nullopt;
    wi.z = std::copysign(wi.z, wo.z);
    // The weight agrees with Evaluate() in expectation only: pdfExact would promise more.
    return BxDFSample{.wi = wi,
                      .weight = DrawAlbedo(wo, wi, context),
                      .pdf = AbsCosTheta(wi) * InvPi,
                      .pdfReverse = AbsCosTheta(wo) * InvPi,
                      .lobe = Lobes::DiffuseReflection,
                      .pdfExact = false};
}

}  // namespace lacquer
