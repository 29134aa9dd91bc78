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
    if (wo.z == 0 || !Any(context.sides, Lobes::Reflection)) return std::nullopt;
    Vec3 wi = SampleCosineHemisphere(u.direction);
    if (wi.z == 0) return std::nullopt;
    wi.z = std::copysign(wi.z, wo.z);
    return BxDFSample{.wi = wi,
                      .weight = {},
                      .pdf = CosineLobePdf(wi),
                      .pdfReverse = CosineLobePdf(wo),
                      .lobe = Lobes::DiffuseReflection};
}

}  // namespace lacquer
