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

Coat CoatOf(const LambertianBase& base) { return {base.model, base.alpha, base.eta, base.tau, base.curves}; }

}  // namespace

bool FindCoat(const StackInterface& top, LambertianBase* base) {
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

bool FindLambertianBase(const Stack& stack, Vec3 wo, Vec3 wi, LambertianBase* base) {
    if (stack.Last() != 1 || !(wo.z > 0) || !(wi.z > 0)) return false;
    const StackInterface &top = stack.interfaces[0], &bottom = stack.interfaces[1];
    const Slab& slab = stack.slabs[0];
    if (slab.Scatters() || !top.HasUnperturbedNormal() || !bottom.HasUnperturbedNormal()) return false;
    if (slab.phase && !slab.IsClear() && slab.phase->HasDirectionalExtinction()) return false;
    const auto* lambertian = std::get_if<LambertianSurface>(&bottom.model);
    if (!lambertian || !FindCoat(top, base)) return false;
    base->reflectance = lambertian->reflectance;
    base->tau = slab.opticalThickness;
    const bool areOfTop = stack.topCurves && stack.topCurves->AreOf(base->model, base->alpha, base->eta);
    base->curves = areOfTop ? stack.topCurves : nullptr;
    return true;
}

namespace {

/// What the base reflects; the light that the coat does is apart.
SampledSpectrum Evaluate(const LambertianBase& base, const Coat& coat, Vec3 wo, Vec3 wi, int maxVertices) {
    return Series(base, coat, maxVertices) * coat.Product(coat.Transmittance(wo.z), coat.Transmittance(wi.z));
}
}  // namespace

SampledSpectrum EvaluateLambertianBase(const LambertianBase& base, Vec3 wo, Vec3 wi, int maxVertices) {
    return Evaluate(base, CoatOf(base), wo, wi, maxVertices);
}

namespace {

/// t(w) from one refraction through a visible facet.
SampledSpectrum SampleTransmittance(const LambertianBase& base, Vec3 w, Rng* rng) {
    // Importance has no factor of eta^2: the series has it.
    const BxDFContext inward{
        .mode = TransportMode::Importance, .sides = Lobes::Transmission, .rng = rng, .needsSamplePdf = false};
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

namespace {

/// How samples for one wo are shared out. Light that meets the coat goes by Fresnel's factor of the facet, so
/// the draws of coat and base are as their energies are if the base loses nothing. What it loses is made good
/// by draws that meet the coat and must be reflected.
class SampleShares {
  public:
    SampleShares(const LambertianBase& base, const Coat& coat, float cosTheta, int maxVertices) {
        const int returns = MaxReturns(maxVertices);
        if (returns < 0 || !base.reflectance) return;
        const float in = coat.ProbabilityIn(cosTheta), back = coat.ProbabilityBack();
        const float sum = GeometricSum(back, returns);
        const float weight = std::min(1.f, MeanBaseWeight(base, coat, cosTheta, back, returns) / sum);
        // in weight : 1 - in, as the energies.
        reflected_ = (1 - in) * (1 - weight) / (1 - in * (1 - weight));
        baseScale_ = (1 - reflected_) * in * sum;
    }
    /// Probability of the draws that are reflected whatever Fresnel's factor is.
    float Reflected() const { return reflected_; }
    /// Density of the base's draws over Coat::PdfOut(wi).
    float BaseScale() const { return baseScale_; }
    /// Probability that a facet with this factor reflects.
    float Reflects(float fresnel) const { return reflected_ + (1 - reflected_) * fresnel; }

  private:
    /// Mean weight of draws that meet the base, all returns added, about: slabs by mean lengths of paths.
    static float MeanBaseWeight(const LambertianBase& base, const Coat& coat, float cosTheta, float back,
                                int returns) {
        if (!base.tau) return (base.reflectance * GeometricSum(base.reflectance * back, returns)).Average();
        const auto cosBelow = [&](float c) { return std::sqrt(1 - (1 - c) * (1 + c) / Sqr(base.eta)); };
        // 1/cos of a cosine lobe within the cone that total reflection leaves: 2/(1 + its edge).
        const float path = 1 / cosBelow(cosTheta) + 2 / (1 + cosBelow(0));
        return (base.reflectance * Exp(-base.tau * path) *
                GeometricSum(base.reflectance * coat.Reflectance(), returns))
            .Average();
    }

    float reflected_ = 1, baseScale_ = 0;
};

/// f0, and the density of all draws that the coat reflects.
BxDFValue EvaluateCoat(const LambertianBase& base, const SampleShares& shares, Vec3 wo, Vec3 wi,
                       const BxDFContext& context) {
    BxDFContext reflection = context;
    reflection.sides = Lobes::Reflection;
    reflection.needsPdf = true;
    BxDFValue value = base.top->Evaluate(wo, wi, reflection);
    value.pdf *= shares.Reflects(FresnelDielectric(Dot(wo, Normalize(wo + wi)), base.eta));
    return value;
}

}  // namespace

float LambertianBasePdf(const LambertianBase& base, Vec3 wo, Vec3 wi, int maxVertices) {
    const BxDFContext context{TransportMode::Radiance, Lobes::BothSides, nullptr};
    const Coat coat = CoatOf(base);
    const SampleShares shares(base, coat, wo.z, maxVertices);
    return EvaluateCoat(base, shares, wo, wi, context).pdf + shares.BaseScale() * coat.PdfOut(wi.z);
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

/// The first meeting with the coat. A mirror lobe's record is complete.
std::optional<BxDFSample> SampleCoat(const LambertianBase& base, const SampleShares& shares, Vec3 wo,
                                     BxDFRandom u, const BxDFContext& context) {
    BxDFContext here = context;
    const float reflected = shares.Reflected();
    if (u.lobe < reflected) {
        here.sides = Lobes::Reflection;
        u.lobe = std::min(u.lobe / reflected, OneMinusEpsilon);
    } else {
        here.sides = Lobes::BothSides;
        u.lobe = std::min((u.lobe - reflected) / (1 - reflected), OneMinusEpsilon);
    }
    std::optional<BxDFSample> sample = base.top->Sample(wo, u, here);
    if (sample && sample->IsReflection() && sample->IsSpecular()) {
        const float probability = shares.Reflects(FresnelDielectric(wo.z, base.eta));
        sample->weight *= sample->pdf / probability;
        sample->pdf = sample->pdfReverse = probability;
    }
    return sample;
}

}  // namespace

std::optional<BxDFSample> SampleLambertianBaseDirection(const LambertianBase& base, Vec3 wo,
                                                        const BxDFRandom& u, const BxDFContext& context,
                                                        int maxVertices) {
    BxDFContext both = context;
    both.sides = Lobes::BothSides;
    both.needsSamplePdf = false;
    const Coat coat = CoatOf(base);
    const SampleShares shares(base, coat, wo.z, maxVertices);
    const std::optional<BxDFSample> first = SampleCoat(base, shares, wo, u, both);
    if (!first || (first->IsReflection() && first->IsSpecular())) return first;
    Vec3 wi = first->wi;
    if (first->IsTransmission()) {
        const std::optional<Vec3> exit = SampleExit(*base.top, both, MaxReturns(maxVertices));
        if (!exit) return std::nullopt;
        wi = *exit;
    }
    const BxDFValue single = EvaluateCoat(base, shares, wo, wi, both);
    const float pdf = single.pdf + shares.BaseScale() * coat.PdfOut(wi.z);
    if (!(pdf > 0)) return std::nullopt;
    const SampledSpectrum f = single.f + Evaluate(base, coat, wo, wi, maxVertices);
    return BxDFSample{.wi = wi, .weight = f * (wi.z / pdf), .pdf = pdf, .lobe = Lobes::DiffuseReflection};
}

}  // namespace lacquer::layered
