#include "layered/stack.h"

#include <algorithm>
#include <cmath>
#include <typeinfo>

namespace lacquer::layered {

StackInterface::StackInterface(const BxDF* scattering) : bxdf(scattering) { Refresh(); }

StackInterface::StackInterface(const BxDF* scattering, const Frame& ownFrame) : StackInterface(scattering) {
    frame = ownFrame;
    hasOwnFrame = true;
}

void StackInterface::Refresh() {
    isSpecular = !IsNonSpecular(bxdf->Flags());
    hasSpecular = IsSpecular(bxdf->Flags());
    transmits = Any(bxdf->Flags(), Lobes::Transmission);
    model = bxdf->Model();
}

std::optional<MicrofacetSurface> StackInterface::IsotropicFacets() const {
    const auto* surface = std::get_if<MicrofacetSurface>(&model);
    if (!surface || surface->alphaX != surface->alphaY || !HasUnperturbedNormal()) return std::nullopt;
    return *surface;
}

std::optional<BxDFSample> StackInterface::Sample(Vec3 wo, const BxDFContext& context) const {
    BxDFContext free = context;
    // Rejection would take stratified numbers without being a continuous function of them.
    free.allowsRejection = !context.rng->HasLeading();
    const float lobe = context.rng->Uniform();
    return Sample(wo, {lobe, context.rng->Uniform2D()}, free);
}

std::optional<BxDFSample> StackInterface::Sample(Vec3 wo, const BxDFRandom& u,
                                                 const BxDFContext& context) const {
    return hasOwnFrame ? SampleInOwnFrame(wo, u, context) : bxdf->Sample(wo, u, context);
}

namespace {

/// True if w is on the same side of the perturbed normal and of the stack's.
bool SidesAgree(Vec3 w, Vec3 local) { return w.z * local.z > 0; }

}  // namespace

// The cosine with the perturbed normal belongs to the side of the lights: f |wi.z| = f_n |n.wi| for radiance,
// and the roles of wo and wi are exchanged for importance.
BxDFValue StackInterface::EvaluateInOwnFrame(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    const Vec3 o = frame.ToLocal(wo), i = frame.ToLocal(wi);
    if (!SidesAgree(wo, o) || !SidesAgree(wi, i)) return {};
    BxDFValue value = bxdf->Evaluate(o, i, context);
    value.f *= context.mode == TransportMode::Radiance ? i.z / wi.z : o.z / wo.z;
    return value;
}

float StackInterface::Pdf(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    if (!hasOwnFrame) return bxdf->Pdf(wo, wi, context);
    const Vec3 o = frame.ToLocal(wo), i = frame.ToLocal(wi);
    return SidesAgree(wo, o) && SidesAgree(wi, i) ? bxdf->Pdf(o, i, context) : 0.f;
}

std::optional<BxDFSample> StackInterface::SampleInOwnFrame(Vec3 wo, const BxDFRandom& u,
                                                           const BxDFContext& context) const {
    const Vec3 o = frame.ToLocal(wo);
    if (!SidesAgree(wo, o)) return std::nullopt;
    std::optional<BxDFSample> sample = bxdf->Sample(o, u, context);
    if (!sample) return std::nullopt;
    const Vec3 i = sample->wi;
    sample->wi = frame.FromLocal(i);
    if (!SidesAgree(sample->wi, i)) return std::nullopt;
    // weight = f |wi.z| / pdf, see EvaluateInOwnFrame().
    if (context.mode == TransportMode::Importance) sample->weight *= (o.z / wo.z) * (sample->wi.z / i.z);
    return sample;
}

bool Stack::Scatters() const {
    return std::any_of(slabs.begin(), slabs.end(), [](const Slab& slab) { return slab.Scatters(); });
}

Slab::Slab(SampledSpectrum thickness, SampledSpectrum scatteringAlbedo, const PhaseFunction* phaseFunction)
    : opticalThickness(thickness), albedo(scatteringAlbedo), phase(phaseFunction) {
    isClear_ = !opticalThickness;
    // Wavelengths that neither scatter nor meet anything need no flights of their own.
    scatters_ = bool(opticalThickness * albedo) && phase;
    isGray_ = opticalThickness == SampledSpectrum(opticalThickness[0]);
    isDirectional_ = phase && phase->HasDirectionalExtinction();
    hasDirectionalAlbedo_ = phase && phase->HasDirectionalAlbedo();
    hasChromaticPhase_ = phase && phase->IsChromatic();
    scattering_ = albedo * opticalThickness;
    if (phase && typeid(*phase) == typeid(HenyeyGreensteinPhase))
        henyeyGreenstein_ = static_cast<const HenyeyGreensteinPhase*>(phase);
}

namespace {

/// An index drawn in proportion to its weight.
int SampleWavelengthIndex(SampledSpectrum weights, float u) {
    u *= weights.Sum();
    for (int i = 0; i < kNumWavelengths - 1; ++i) {
        if (u < weights[i]) return i;
        u -= weights[i];
    }
    return kNumWavelengths - 1;
}

}  // namespace

Flight Slab::SampleOtherFlight(float perDepth, float x, Vec3 w, SampledSpectrum throughput, Rng& rng,
                               float forcedShare) const {
    const bool isDown = w.z < 0;
    const float room = isDown ? 1 - x : x, end = isDown ? 1.f : 0.f;
    float dx = room;
    bool scatters = true;
    if (forcedShare > 0 && rng.Uniform() < forcedShare) {
        dx *= rng.Uniform();
    } else {
        const int wavelength = isGray_ ? 0 : SampleWavelengthIndex(throughput, rng.Uniform());
        const float extinction = opticalThickness[wavelength] * perDepth;
        const float optical = -Log(1 - rng.Uniform());
        scatters = optical < extinction * room;
        if (scatters) dx = optical / extinction;
    }
    Flight flight{scatters, scatters ? (isDown ? x + dx : x - dx) : end, 1, CrossAt(perDepth, dx)};
    flight.pdf = flight.crossing.Pdf(scatters);
    if (!isGray_) {
        const SampledSpectrum& transmittance = flight.crossing.transmittance;
        const SampledSpectrum pdfs = scatters ? opticalThickness * transmittance * perDepth : transmittance;
        // Shares of the throughput, free of underflow.
        const SampledSpectrum shares = throughput / throughput.MaxComponent();
        flight.pdf = (pdfs * shares).Sum() / shares.Sum();
    }
    if (forcedShare > 0) flight.pdf = (1 - forcedShare) * flight.pdf + (scatters ? forcedShare / room : 0.f);
    return flight;
}

BxDFValue Slab::ScatterOther(Vec3 wo, Vec3 wi) const {
    if (hasChromaticPhase_) return ScatterSpectral(wo, wi);
    const PhaseValue value = phase->Evaluate(wo, wi);
    return {scattering_ * (RelativeScattering(wo) * value.p), value.pdf, value.pdfReverse};
}

SlabSample Slab::SampleOtherScatter(Vec3 wo, SampledSpectrum throughput, Rng& rng) const {
    if (hasChromaticPhase_) return SampleSpectral(wo, throughput, rng);
    const PhaseSample s = phase->Sample(wo, rng);
    return {s.wi, scattering_ * (RelativeScattering(wo) * s.weight), s.pdf, s.pdfReverse};
}

BxDFValue Slab::ScatterSpectral(Vec3 wo, Vec3 wi) const {
    const SpectralPhaseValue value = phase->EvaluateSpectral(wo, wi);
    return {scattering_ * (RelativeScattering(wo) * value.p), value.pdf.Average(),
            value.pdfReverse.Average()};
}

SlabSample Slab::SampleSpectral(Vec3 wo, SampledSpectrum throughput, Rng& rng) const {
    if (!(throughput.MaxComponent() > 0)) throughput = SampledSpectrum(1);  // all of it underflowed
    const SampledSpectrum shares = throughput / throughput.MaxComponent();
    const Vec3 wi = phase->SampleAt(SampleWavelengthIndex(shares, rng.Uniform()), wo, rng);
    const SpectralPhaseValue value = phase->EvaluateSpectral(wo, wi);
    const float pdf = (value.pdf * shares).Sum() / shares.Sum();
    // A direction at the end of a lobe may be outside by rounding.
    const float weight = pdf > 0 ? RelativeScattering(wo) / pdf : 0.f;
    return {wi, scattering_ * (weight * value.p), value.pdf.Average(), value.pdfReverse.Average()};
}

}  // namespace lacquer::layered
