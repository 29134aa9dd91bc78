#include "pbrt/bxdfs/diffuse.h"

#include "pbrt/core/sampling.h"

namespace lacquer {

BxDFValue DiffuseBxDF::Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    if (!SameHemisphere(wo, wi) || !Any(context.sides, Lobes::Reflection) || !reflectance_) return {};
    return {reflectance_ * InvPi, AbsCosTheta(wi) * InvPi, AbsCosTheta(wo) * InvPi};
}

std::optional<BxDFSample> DiffuseBxDF::Sample(Vec3 wo, const BxDFRandom& u,
                                              const BxDFContext& context) const {
    if (wo.z == 0 || !Any(context.sides, Lobes::Reflection) || !reflectance_) return std::nullopt;
    Vec3 wi = SampleCosineHemisphere(u.direction);
    if (wi.z == 0) return std::nullopt;
    wi.z = std::copysign(wi.z, wo.z);
    return BxDFSample{.wi = wi,
                      .weight = reflectance_,
                      .pdf = AbsCosTheta(wi) * InvPi,
                      .pdfReverse = AbsCosTheta(wo) * InvPi,
                      .lobe = Lobes::DiffuseReflection};
}

}  // namespace lacquer
