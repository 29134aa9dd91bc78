#include "pbrt/bxdfs/rough_diffuse.h"

#include "pbrt/bxdfs/cosine_lobe.h"

namespace lacquer {

namespace {

// [Portsmouth et al. 2025], eq. 14 and 20: what single reflection has by direction, and on average.
constexpr float kC1 = 0.5f - 2 / (3 * Pi), kC2 = 2.f / 3 - 28 / (15 * Pi);

}  // namespace

RoughDiffuseBxDF::RoughDiffuseBxDF(SampledSpectrum reflectance, float roughness)
    : reflectance_(reflectance), roughness_(roughness), scale_(1 / (1 + kC1 * roughness)) {
    const float mean = scale_ * (1 + kC2 * roughness), lost = 1 - mean;
    // Each further reflection takes its share of colour.
    rescattered_ =
        lost > 0 ? reflectance * reflectance * mean / (1 - reflectance * lost) / lost : SampledSpectrum(0);
}

float RoughDiffuseBxDF::SingleAlbedo(float cosTheta) const {
    const float sine = SafeSqrt(1 - cosTheta * cosTheta);
    const float angle = std::acos(std::min(cosTheta, 1.f));
    // tan theta (1 - sin^3 theta), without the quotient by 0 at grazing angles.
    const float last = sine * cosTheta * (1 + sine + sine * sine) / (1 + sine);
    const float G = sine * (angle - sine * cosTheta - 2.f / 3) + 2.f / 3 * last;
    return scale_ * (1 + roughness_ * InvPi * G);
}

SampledSpectrum RoughDiffuseBxDF::Scaled(Vec3 wo, Vec3 wi) const {
    const float co = AbsCosTheta(wo), ci = AbsCosTheta(wi);
    const float s = Dot(wo, wi) - co * ci, t = s > 0 ? std::max(co, ci) : 1.f;
    const float single = scale_ * (1 + roughness_ * s / t);
    return reflectance_ * single + rescattered_ * ((1 - SingleAlbedo(co)) * (1 - SingleAlbedo(ci)));
}

BxDFValue RoughDiffuseBxDF::Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    if (!InCosineLobe(wo, wi, context) || !reflectance_) return {};
    return {Scaled(wo, wi) * InvPi, CosineLobePdf(wi), CosineLobePdf(wo)};
}

std::optional<BxDFSample> RoughDiffuseBxDF::Sample(Vec3 wo, const BxDFRandom& u,
                                                   const BxDFContext& context) const {
    if (!reflectance_) return std::nullopt;
    std::optional<BxDFSample> sample = SampleCosineLobe(wo, u, context);
    if (sample) sample->weight = Scaled(wo, sample->wi);
    return sample;
}

}  // namespace lacquer
