#include "pbrt/integrators/guided_sampling.h"

#include <algorithm>

namespace lacquer {
namespace {

/// A direction that something else has drawn, with density one, as if the BxDF had.
std::optional<BxDFSample> SampleAt(const SurfaceInteraction& si, const Bsdf& bsdf, Vec3 wi,
                                   BxDFContext context) {
    context.needsPdf = false;
    const BxDFValue value = bsdf.Evaluate(wi, context);
    BxDFSample sample;
    sample.wi = wi;
    sample.weight = value.f * AbsDot(wi, si.shading.n);
    if (!sample.weight) return {};
    sample.pdf = value.pdf;
    sample.pdfExact = value.pdf > 0;
    const Lobes side =
        SameHemisphere(bsdf.wo, bsdf.frame.ToLocal(wi)) ? Lobes::Reflection : Lobes::Transmission;
    sample.lobe = side | (Any(bsdf.Flags(), Lobes::Diffuse) ? Lobes::Diffuse : Lobes::Glossy);
    return sample;
}

SpectralPhaseValue ValueOf(const PhaseFunction& phase, Vec3 wo, Vec3 wi) {
    if (phase.IsChromatic()) return phase.EvaluateSpectral(wo, wi);
    const PhaseValue alike = phase.Evaluate(wo, wi);
    SpectralPhaseValue value;
    value.p = SampledSpectrum(alike.p);
    value.pdf = SampledSpectrum(alike.pdf);
    return value;
}

}  // namespace

GuidedFacing FacingOf(const SurfaceInteraction& si, const Bsdf& bsdf) {
    return FacingOf(Dot(bsdf.wo, bsdf.frame.ToLocal(si.n)) < 0 ? -si.n : si.n);
}

std::optional<BxDFSample> SampleGuided(const GuidedDensity& guided, const SurfaceInteraction& si,
                                       const Bsdf& bsdf, const BxDFRandom& u, const BxDFContext& context,
                                       GuidedVertex* vertex) {
    const float share = guided.ScatteringShare();
    const bool isScattered = u.lobe < share;
    DirectionalTree::Direction direction{};
    if (!isScattered) direction = guided.Cell().Directions().Sample(u.direction);
    std::optional<BxDFSample> sample =
        isScattered ? bsdf.Sample({std::min(u.lobe / share, OneMinusEpsilon), u.direction}, context)
                    : SampleAt(si, bsdf, direction.w, context);
    if (!sample) return sample;
    const float scattering = sample->pdfExact ? sample->pdf : bsdf.Pdf(sample->wi, context);
    const float learned = !isScattered           ? direction.pdf
                          : sample->IsSpecular() ? 0
                                                 : guided.Learned(sample->wi);
    const float pdf = guided.Of(scattering, learned);
    if (isScattered && learned == 0) {
        // Whatever the density is: an estimate may be zero.
        sample->weight /= share;
        sample->pdf *= share;
    } else {
        if (!(pdf > 0)) return {};
        sample->weight *= (isScattered ? scattering : 1) / pdf;
        // So that weight and density make the value, in an estimate of the density as well.
        sample->pdf =
            isScattered && !sample->pdfExact && scattering > 0 ? sample->pdf * pdf / scattering : pdf;
    }
    vertex->wi = sample->wi;
    vertex->cosine = AbsDot(sample->wi, si.shading.n);
    vertex->density = guided;
    vertex->scattering = scattering;
    vertex->learned = learned;
    vertex->isSpecular = sample->IsSpecular();
    return sample;
}

std::optional<GuidedPhaseSample> SampleGuided(const GuidedDensity& guided, const PhaseFunction& phase,
                                              Vec3 wo, Rng* rng, GuidedVertex* vertex) {
    const bool isScattered = rng->Uniform() < guided.ScatteringShare();
    GuidedPhaseSample sample;
    sample.wi =
        isScattered ? phase.Sample(wo, *rng).wi : guided.Cell().Directions().Sample(rng->Uniform2D()).w;
    const SpectralPhaseValue value = ValueOf(phase, wo, sample.wi);
    const float learned = guided.Learned(sample.wi);
    sample.pdf = guided.Of(value.pdf, learned);
    if (!(sample.pdf[0] > 0)) return {};
    sample.weight = value.p / sample.pdf[0];
    if (!sample.weight) return {};
    vertex->wi = sample.wi;
    vertex->density = guided;
    vertex->scattering = value.pdf[0];
    vertex->learned = learned;
    return sample;
}

}  // namespace lacquer
