#include "pbrt/bxdfs/diffuse.h"

#include "pbrt/bxdfs/cosine_lobe.h"

namespace lacquer {

BxDFValue DiffuseBxDF::Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    if (!InCosineLobe(wo, wi, context) || !reflectance_) return {};
    return {reflectance_ * InvPi, CosineLobePdf(wi), CosineLobePdf(wo)};
}

std::optional<BxDFSample> DiffuseBxDF::Sample(Vec3 wo, const BxDFRandom& u,
                                              const BxDFContext& context) const {
    if (!reflectance_) return std::nullopt;
    std::optional<BxDFSample> sample = SampleCosineLobe(wo, u, context);
    if (sample) sample->weight = reflectance_;
    return sample;
}

}  // namespace lacquer
