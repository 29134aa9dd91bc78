#include "pbrt/bxdfs/normalized_fresnel.h"

#include "pbrt/bxdfs/cosine_lobe.h"
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
    if (!InCosineLobe(wo, wi, context)) return {};
    return {SampledSpectrum(Albedo(AbsCosTheta(wi), context.mode) * InvPi), CosineLobePdf(wi),
            CosineLobePdf(wo)};
}

std::optional<BxDFSample> NormalizedFresnelBxDF::Sample(Vec3 wo, const BxDFRandom& u,
                                                        const BxDFContext& context) const {
    std::optional<BxDFSample> sample = SampleCosineLobe(wo, u, context);
    if (sample) sample->weight = SampledSpectrum(Albedo(AbsCosTheta(sample->wi), context.mode));
    return sample;
}

}  // namespace lacquer
