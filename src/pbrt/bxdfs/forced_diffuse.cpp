#include "pbrt/bxdfs/forced_diffuse.h"

#include "pbrt/bxdfs/cosine_lobe.h"

namespace lacquer {

/// An unbiased estimate of R. The direction is that of the camera's side whichever way light is traced: so f
/// is adjoint to itself.
SampledSpectrum ForcedDiffuseBxDF::SampleAlbedo(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    const Vec3 seenFrom = context.mode == TransportMode::Radiance ? wo : wi;
    const BxDFContext draw{
        .rng = context.rng, .needsPdf = false, .allowsRejection = true, .counters = context.counters};
    const float uLobe = context.rng->Uniform();
    const auto sample = model_->Sample(seenFrom, {uLobe, context.rng->Uniform2D()}, draw);
    return sample ? sample->weight : SampledSpectrum(0);
}

BxDFValue ForcedDiffuseBxDF::Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    if (!InCosineLobe(wo, wi, context)) return {};
    return {SampleAlbedo(wo, wi, context) * InvPi, CosineLobePdf(wi), CosineLobePdf(wo)};
}

float ForcedDiffuseBxDF::Pdf(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    return InCosineLobe(wo, wi, context) ? CosineLobePdf(wi) : 0.f;
}

std::optional<BxDFSample> ForcedDiffuseBxDF::Sample(Vec3 wo, const BxDFRandom& u,
                                                    const BxDFContext& context) const {
    std::optional<BxDFSample> sample = SampleCosineLobe(wo, u, context);
    if (!sample) return sample;
    sample->weight = SampleAlbedo(wo, sample->wi, context);
    sample->pdfExact = false;  // the weight agrees with Evaluate() in expectation only
    return sample;
}

}  // namespace lacquer
