// What models share that reflect to the side of wo, and draw by the cosine there.
#pragma once

#include "pbrt/base/bxdf.h"
#include "pbrt/core/sampling.h"

namespace lacquer {

/// True where such a model may scatter at all.
inline bool InCosineLobe(Vec3 wo, Vec3 wi, const BxDFContext& context) {
    return SameHemisphere(wo, wi) && Any(context.sides, Lobes::Reflection);
}

/// Density of a draw [1/sr], and with the directions exchanged.
inline float CosineLobePdf(Vec3 wi) { return AbsCosTheta(wi) * InvPi; }

/// A draw without its weight, which is pi f. Empty where nothing can be reflected.
inline std::optional<BxDFSample> SampleCosineLobe(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) {
    std::optional<BxDFSample> sample;
    if (wo.z == 0 || !Any(context.sides, Lobes::Reflection)) return sample;
    Vec3 wi = SampleCosineHemisphere(u.direction);
    if (wi.z == 0) return sample;
    wi.z = std::copysign(wi.z, wo.z);
    sample.emplace();
    sample->wi = wi;
    sample->pdf = CosineLobePdf(wi);
    sample->pdfReverse = CosineLobePdf(wo);
    sample->lobe = Lobes::DiffuseReflection;
    return sample;
}

}  // namespace lacquer
