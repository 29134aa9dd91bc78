#include "pbrt/bxdfs/diffuse_transmission.h"

#include "pbrt/core/sampling.h"

namespace lacquer {

Lobes DiffuseTransmissionBxDF::Flags() const {
    return (reflectance_ ? Lobes::DiffuseReflection : Lobes::None) |
           (transmittance_ ? Lobes::DiffuseTransmission : Lobes::None);
}

float DiffuseTransmissionBxDF::ReflectionProbability(Lobes sides) const {
    const float r = Any(sides, Lobes::Reflection) ? reflectance_.MaxComponent() : 0.f;
    const float t = Any(sides, Lobes::Transmission) ? transmittance_.MaxComponent() : 0.f;
    return r + t > 0 ? r / (r + t) : -1;
}

BxDFValue DiffuseTransmissionBxDF::Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    const float pr = ReflectionProbability(context.sides);
    if (wo.z == 0 || wi.z == 0 || pr < 0) return {};
    const bool reflects = SameHemisphere(wo, wi);
    const float probability = reflects ? pr : 1 - pr;
    if (!(probability > 0)) return {};
    return {(reflects ? reflectance_ : transmittance_) * InvPi, probability * AbsCosTheta(wi) * InvPi,
            probability * AbsCosTheta(wo) * InvPi};
}

std::optional<BxDFSample> DiffuseTransmissionBxDF::Sample(Vec3 wo, const BxDFRandom& u,
                                                          const BxDFContext& context) const {
    const float pr = ReflectionProbability(context.sides);
    if (wo.z == 0 || pr < 0) return std::nullopt;
    Vec3 wi = SampleCosineHemisphere(u.direction);
    if (wi.z == 0) return std::nullopt;
    const bool reflects = u.lobe < pr;
    const float probability = reflects ? pr : 1 - pr;
    wi.z = std::copysign(wi.z, reflects ? wo.z : -wo.z);
    return BxDFSample{.wi = wi,
                      .weight = (reflects ? reflectance_ : transmittance_) / probability,
                      .pdf = probability * AbsCosTheta(wi) * InvPi,
                      .pdfReverse = probability * AbsCosTheta(wo) * InvPi,
                      .lobe = reflects ? Lobes::DiffuseReflection : Lobes::DiffuseTransmission};
}

}  // namespace lacquer
