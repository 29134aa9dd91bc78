#include "layered/lambertian/lambertian_base.h"

#include "pbrt/core/sampling.h"

namespace lacquer::layered {
namespace {

/// Internal reflections that the longest path may have: it has 3 + 2k vertices. Negative if none may.
int MaxReturns(int maxVertices) { return maxVertices < 3 ? -1 : (maxVertices - 3) / 2; }

/// 1 + q + ... + q^last for q in [0,1).
template <class Value>
Value GeometricSum(Value q, int last) {
    Value power(1), square = q;
    for (int n = last + 1; n > 0; n >>= 1) {
        if (n & 1) power = power * square;
        square = square * square;
    }
    return (Value(1) - power) / (Value(1) - q);
}

/// All but t(wo) t(wi).
SampledSpectrum Series(const LambertianBase& base, const Coat& coat, int maxVertices) {
    const int returns = MaxReturns(maxVertices);
    if (returns < 0) return SampledSpectrum(0);
    const SampledSpectrum direct = base.reflectance * (InvPi / Sqr(base.eta));
    if (returns == 0) return direct;
    return direct * GeometricSum(base.reflectance * coat.Reflectance(), returns);
}

Coat CoatOf(const LambertianBase& base) { return {base.model, base.alpha, base.eta, base.tau}; }

/// Sets what belongs to the coat. False if Coat does not know it.
bool SetCoat(const StackInterface& top, LambertianBase* base) {
    base->top = &top;
    if (const auto* smooth = std::get_if<SmoothSurface>(&top.model)) {
        base->alpha = 0;
        base->eta = smooth->eta;
    } else if (const auto* rough = std::get_if<MicrofacetSurface>(&top.model)) {
        if (rough->alphaX != rough->alphaY) return false;
        base->model = rough->model;
        base->alpha = rough->alphaX;
        base->eta = rough->eta;
    } else {
        return false;
    }
    return Coat::IsKnown(base->alpha, base->eta);
}

}  // namespace

bool FindLambertianBase(const Stack& stack, Vec3 wo, Vec3 wi, LambertianBase* base) {
    if (stack.Last() != 1 || !(wo.z > 0) || !(wi.z > 0)) return false;
    const StackInterface &top = stack.interfaces[0], &bottom = stack.interfaces[1];
    const Slab& slab = stack.slabs[0];
    if (slab.Scatters() || !top.HasUnperturbedNormal() || !bottom.HasUnperturbedNormal()) return false;
    if (slab.phase && !slab.IsClear() && slab.phase->HasDirectionalExtinction()) return false;
    const auto* lambertian = std::get_if<LambertianSurface>(&bottom.model);
    if (!lambertian || !SetCoat(top, base)) return false;
    base->reflectance = lambertian->reflectance;
    base->tau = slab.opticalThickness;
    return true;
}

namespace {

/// What the base reflects; the light that the coat does is apart.
SampledSpectrum Evaluate(const LambertianBase& base, const Coat& coat, Vec3 wo, Vec3 wi, int maxVertices) {
    return Series(base, coat, maxVertices) * coat.Product(coat.Transmittance(wo.z), coat.Transmittance(wi.z));
}
/// Density of its part of the draws.
float Pdf(const LambertianBase& base, const Coat& coat, Vec3 wo, Vec3 wi, int maxVertices) {
    const int returns = MaxReturns(maxVertices);
    if (returns < 0 || !base.reflectance) return 0;
    return coat.ProbabilityIn(wo.z) * coat.PdfOut(wi.z) * GeometricSum(coat.ProbabilityBack(), returns);
}

}  // namespace

SampledSpectrum EvaluateLambertianBase(const LambertianBase& base, Vec3 wo, Vec3 wi, int maxVertices) {
    return Evaluate(base, CoatOf(base), wo, wi, maxVertices);
}

namespace {

/// t(w) from one refraction through a visible facet.
SampledSpectrum SampleTransmittance(const LambertianBase& base, Vec3 w, Rng* rng) {
    // Importance has no factor of eta^2: the series has it.
    const BxDFContext inward{TransportMode::Importance, Lobes::Transmission, rng};
    const std::optional<BxDFSample> sample = base.top->Sample(w, inward);
    if (!sample || sample->wi.z == 0) return SampledSpectrum(0);
    return base.tau ? sample->weight * Exp(-(base.tau / Slab::AbsCos(sample->wi))) : sample->weight;
}

}  // namespace

SampledSpectrum EstimateLambertianBase(const LambertianBase& base, Vec3 wo, Vec3 wi,
                                       const BxDFContext& context, int maxVertices) {
    const SampledSpectrum o = SampleTransmittance(base, wo, context.rng);
    if (!o) return o;
    return o * SampleTransmittance(base, wi, context.rng) * Series(base, CoatOf(base), maxVertices);
}

float LambertianBasePdf(const LambertianBase& base, Vec3 wo, Vec3 wi, int maxVertices) {
    const BxDFContext context{TransportMode::Radiance, Lobes::BothSides, nullptr};
    return base.top->Evaluate(wo, wi, context).pdf + Pdf(base, CoatOf(base), wo, wi, maxVertices);
}

namespace {

/// Where light that the base reflects leaves: each time it comes up with a cosine lobe, whatever was before.
std::optional<Vec3> SampleExit(const StackInterface& top, const BxDFContext& context, int maxReturns) {
    for (int k = 0; k <= maxReturns; ++k) {
        const Vec3 below = -SampleCosineHemisphere(context.rng->Uniform2D());
        const std::optional<BxDFSample> sample = top.Sample(below, context);
        if (!sample || sample->wi.z == 0) return std::nullopt;
        if (sample->IsTransmission()) return sample->wi;
    }
    return std::nullopt;
}

}  // namespace

std::optional<BxDFSample> SampleLambertianBaseDirection(const LambertianBase& base, Vec3 wo,
                                                        const BxDFRandom& u, const BxDFContext& context,
                                                        int maxVertices) {
    BxDFContext both = context;
    both.sides = Lobes::BothSides;
    const std::optional<BxDFSample> first = base.top->Sample(wo, u, both);
    if (!first || (first->IsReflection() && first->IsSpecular())) return first;
    Vec3 wi = first->wi;
    if (first->IsTransmission()) {
        if (!base.reflectance) return std::nullopt;
        const std::optional<Vec3> exit = SampleExit(*base.top, both, MaxReturns(maxVertices));
        if (!exit) return std::nullopt;
        wi = *exit;
    }
    const Coat coat = CoatOf(base);
    const BxDFValue single = base.top->Evaluate(wo, wi, both);
    const float pdf = single.pdf + Pdf(base, coat, wo, wi, maxVertices);
    if (!(pdf > 0)) return std::nullopt;
    const SampledSpectrum f = single.f + Evaluate(base, coat, wo, wi, maxVertices);
    return BxDFSample{.wi = wi, .weight = f * (wi.z / pdf), .pdf = pdf, .lobe = Lobes::DiffuseReflection};
}

}  // namespace lacquer::layered
