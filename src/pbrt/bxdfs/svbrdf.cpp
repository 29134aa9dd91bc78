#include "pbrt/bxdfs/svbrdf.h"

#include "pbrt/bxdfs/cosine_lobe.h"
#include "pbrt/scattering/microfacet.h"

namespace lacquer {

namespace {

constexpr float kEpsilon = 1e-6f;

/// How far Fresnel's factor is on its way from normal incidence to 1 [Karis 2013].
float FresnelWeight(float cosine) {
    constexpr float kLn2 = 0.69314718f;
    return Exp(kLn2 * (-5.55473f * cosine - 6.98316f) * cosine);
}

/// Part of the energy of the GGX lobe that the constant in its denominator leaves, about: with u = (1 -
/// cos^2) + alpha^2 cos^2, which grows from alpha^2 to 1, the integral of alpha^2 du / (u^2 + epsilon / pi).
float EnergyLeft(float alpha) {
    const float ratio = Sqr(alpha) / std::sqrt(kEpsilon * InvPi);
    return ratio * std::atan(1 / ratio);
}

float ClampedAlpha(float alpha) { return alpha > kSmoothAlpha ? std::min(alpha, 1.f) : kSmoothAlpha; }

}  // namespace

SvbrdfBxDF::SvbrdfBxDF(SampledSpectrum albedo, SampledSpectrum specular, float alpha, bool conserve)
    : diffuse_(albedo * (1 - specular)),
      specular_(specular),
      meanDiffuse_(diffuse_.Average()),
      meanSpecular_(specular.Average()),
      glossyEnergy_(EnergyLeft(ClampedAlpha(alpha))),
      facets_(ClampedAlpha(alpha), ClampedAlpha(alpha)),
      conserve_(conserve) {}

float SvbrdfBxDF::GlossyShare(float cosTheta) const {
    const float weight = FresnelWeight(cosTheta);
    const float glossy = glossyEnergy_ * (meanSpecular_ + (1 - meanSpecular_) * weight);
    const float diffuse = meanDiffuse_ * (conserve_ ? 1 - weight : 1.f);
    return glossy / (glossy + diffuse);
}

BxDFValue SvbrdfBxDF::Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    if (!InCosineLobe(wo, wi, context)) return {};
    const float co = AbsCosTheta(wo), ci = AbsCosTheta(wi);
    const MicrofacetTerms terms = ReflectionTerms(facets_, wo, wi);
    const float shareO = GlossyShare(co), shareI = GlossyShare(ci);

    // D without the difference of 1 and cos^2, which has no digits in narrow lobes.
    const float alpha = facets_.AlphaX(), alpha2 = Sqr(alpha);
    const float u = Sqr(terms.wm.x) + Sqr(terms.wm.y) + Sqr(terms.wm.z) * alpha2;
    const float D = alpha2 / (Pi * Sqr(u) + kEpsilon);
    const float k = alpha / 2 + kEpsilon;
    const float G = co / (co * (1 - k) + k) * (ci / (ci * (1 - k) + k));
    const SampledSpectrum F = specular_ + (1 - specular_) * FresnelWeight(AbsDot(wo, terms.wm));
    SampledSpectrum f = diffuse_ * InvPi;
    // (1 - F(o)) (1 - F(i)) / (1 - s)^2: the reflectance at normal incidence cancels.
    if (conserve_) f *= (1 - FresnelWeight(co)) * (1 - FresnelWeight(ci));
    f += F * (D * G / (4 * co * ci + kEpsilon));
    return {f, Lerp(shareO, CosineLobePdf(wi), terms.pdf), Lerp(shareI, CosineLobePdf(wo), terms.pdfReverse)};
}

std::optional<BxDFSample> SvbrdfBxDF::Sample(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const {
    const bool isGlossy = u.lobe < GlossyShare(AbsCosTheta(wo));
    std::optional<BxDFSample> sample = SampleCosineLobe(wo, u, context);
    if (!sample) return sample;
    if (isGlossy) {
        const Vec3 w = wo.z < 0 ? -wo : wo;
        sample->wi = Normalize(Reflect(w, facets_.SampleVisible(w, u.direction)));
        if (wo.z < 0) sample->wi = -sample->wi;
        sample->lobe = Lobes::GlossyReflection;
    }
    const BxDFValue value = Evaluate(wo, sample->wi, context);
    if (!(value.pdf > 0)) return std::nullopt;
    sample->weight = value.f * (AbsCosTheta(sample->wi) / value.pdf);
    sample->pdf = value.pdf;
    sample->pdfReverse = value.pdfReverse;
    return sample;
}

void SvbrdfBxDF::Regularize() {
    const float alpha = Alphas(facets_.AlphaX(), facets_.AlphaX()).Regularized().x;
    facets_ = TrowbridgeReitz(alpha, alpha);
    glossyEnergy_ = EnergyLeft(alpha);
}

}  // namespace lacquer
