#include "pbrt/bxdfs/normalized_fresnel.h"

#include "pbrt/core/sampling.h"
#include "pbrt/scattering/bssrdf_table.h"
#include "pbrt/scattering/fresnel.h"

namespace lacquer {

NormalizedFresnelBxDF::NormalizedFresnelBxDF(float eta)
    : eta_(eta), normalization_(1 / (1 - 2 * FresnelMoment1(1 / eta))) {}

float NormalizedFresnelBxDF::Albedo(float cosTheta_i, TransportMode mode) const {
    const float f = (1 - FresnelDielectric(cosTheta_i, eta_)) * normalization_;
    return mode == TransportMode::Radiance ? Sqr(eta_) * f : f;
}

BxDFValue NormalizedFresnelBxDF::Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    if (!SameHemisphere(wo, wi) || !Any(context.sides, Lobes::Reflection)) return {};
    return {SampledSpectrum(Albedo(AbsCosTheta(wi), context.mode) * InvPi), AbsCosTheta(wi) * InvPi,
            AbsCosTheta(wo) * InvPi};
}

std::optional<BxDFSample> NormalizedFresnelBxDF::Sample(Vec3 wo, const BxDFRandom& u,
                                                        const BxDFContext& context) const {
    if (wo.z == 0 || !Any(context.sides, Lobes::Reflection)) return std::nullopt;
    Vec3 wi = SampleCosineHemisphere(u.direction);
    if (wi.z == 0) return std::nullopt;
    wi.z = std::copysign(wi.z, wo.z);
    return BxDFSample{.wi = wi,
                      .weight = SampledSpectrum(Albedo(AbsCosTheta(wi), context.mode)),
                      .pdf = AbsCosTheta(wi) * InvPi,
                      .pdfReverse = AbsCosTheta(wo) * InvPi,
                      .lobe = Lobes::DiffuseReflection};
}

}  // namespace lacquer
