#include "pbrt/bxdfs/thin_dielectric.h"

#include "pbrt/scattering/fresnel.h"

namespace lacquer {

std::optional<BxDFSample> ThinDielectricBxDF::Sample(Vec3 wo, const BxDFRandom& u,
                                                     const BxDFContext& context) const {
    if (wo.z == 0) return std::nullopt;
    // Sum the geometric series R + T R T + T R^3 T + ... = 2R / (1 + R), with T = 1 - R.
    const float single = FresnelDielectric(AbsCosTheta(wo), eta_);
    const float reflectance = 2 * single / (1 + single), transmittance = 1 - reflectance;
    // Choose a side by energy.
    const float r = Any(context.sides, Lobes::Reflection) ? reflectance : 0.f;
    const float t = Any(context.sides, Lobes::Transmission) ? transmittance : 0.f;
    if (!(r + t > 0)) return std::nullopt;
    const float probability = r / (r + t);
    if (u.lobe < probability)
        return BxDFSample{.wi = {-wo.x, -wo.y, wo.z},
                          .weight = SampledSpectrum(r + t),
                          .pdf = probability,
                          .pdfReverse = probability,
                          .lobe = Lobes::SpecularReflection};
    return BxDFSample{.wi = -wo,
                      .weight = SampledSpectrum(r + t),
                      .pdf = 1 - probability,
                      .pdfReverse = 1 - probability,
                      .lobe = Lobes::SpecularTransmission};
}

}  // namespace lacquer
