#include "pbrt/bxdfs/hair.h"

#include <type_traits>

#include "pbrt/core/sampling.h"
#include "pbrt/scattering/bessel.h"
#include "pbrt/scattering/fresnel.h"

namespace lacquer {

namespace {

constexpr int kLast = kNumFibrePaths - 1;

constexpr float Power(float x, int n) {
    float result = 1;
    for (; n > 0; n /= 2, x *= x)
        if (n % 2 == 1) result *= x;
    return result;
}

/// The angle in [-pi, pi]; for arguments within a few turns.
float WrapAngle(float x) { return x - 2 * Pi * std::nearbyint(x * Inv2Pi); }

}  // namespace

// The widths are fits by which beta feels even and beta = 1 is about uniform [Chiang et al. 2016, eq. 7, 8].
HairBxDF::HairBxDF(const Parameters& parameters)
    : h_(parameters.h), eta_(parameters.eta), gamma_o_(SafeASin(parameters.h)), sigma_a_(parameters.sigma_a) {
    const float m = parameters.beta_m, n = parameters.beta_n;
    const float v = Sqr(0.726f * m + 0.812f * m * m + 3.7f * Power(m, 20));
    const float variances[3] = {v, 0.25f * v, 4 * v};
    for (size_t p = 0; p < 3; ++p) {
        const float inverse = 1 / variances[p];
        longitudinal_[p] = {variances[p], inverse, inverse / -std::expm1(-2 * inverse)};
    }
    // sqrt(pi / 8) takes a standard deviation to the scale of a logistic.
    s_ = 0.626657069f * (0.265f * n + 1.194f * n * n + 5.372f * Power(n, 22));
    logisticNorm_ = 1 / std::tanh(Pi / (2 * s_));
    // The scales lean toward the root [Marschner et al. 2003, table 1].
    const float a = parameters.alpha, angles[3] = {-2 * a, a, 4 * a};
    for (size_t p = 0; p < 3; ++p) tilt_[p] = {std::sin(angles[p]), std::cos(angles[p])};
}

HairBxDF::Outgoing HairBxDF::At(Vec3 wo) const {
    Outgoing o;
    o.sinTheta = std::clamp(wo.x, -1.f, 1.f);
    o.cosTheta = SafeSqrt(1 - Sqr(o.sinTheta));
    o.phi = ATan2(wo.z, wo.y);
    // In the normal plane the fibre refracts like a circle of a larger index [Marschner et al. 2003, app. B].
    const float sin2Theta = Sqr(o.sinTheta), etaPrime = SafeSqrt(Sqr(eta_) - sin2Theta) / o.cosTheta;
    const float sinGamma_t = etaPrime > 0 ? std::clamp(h_ / etaPrime, -1.f, 1.f) : 1.f;
    o.gamma_t = SafeASin(sinGamma_t);
    const float cosGamma_t = SafeSqrt(1 - Sqr(sinGamma_t));
    const float cosTheta_t = std::max(SafeSqrt(1 - sin2Theta / Sqr(eta_)), 1e-4f);
    const SampledSpectrum T = Exp(sigma_a_ * (-2 * cosGamma_t / cosTheta_t));

    o.A = Attenuations(o.cosTheta, T);
    float sum = 0;
    for (size_t p = 0; p < kNumFibrePaths; ++p) sum += o.weights[p] = o.A[p].Average();
    for (float& weight : o.weights) weight = sum > 0 ? weight / sum : 0.f;
    return o;
}

/// [Chiang et al. 2016, sec. 3.3], with the sum of the geometric series for all longer paths.
HairBxDF::PathSpectra HairBxDF::Attenuations(float cosTheta_o, SampledSpectrum T) const {
    const float F = FresnelDielectric(cosTheta_o * SafeSqrt(1 - Sqr(h_)), eta_);
    PathSpectra A;
    A[0] = SampledSpectrum(F);
    A[1] = Sqr(1 - F) * T;
    A[2] = A[1] * T * F;
    A[3] = SafeDivide(A[2] * T * F, 1.f - T * F);
    return A;
}

HairBxDF::Inclination HairBxDF::Tilted(int p, const Outgoing& o) const {
    if (p == kLast) return {o.sinTheta, o.cosTheta};
    const Inclination& t = tilt_[size_t(p)];
    // A tilt past the pole comes out on the other side of the fibre, at the same inclination.
    return {o.sinTheta * t.cosine + o.cosTheta * t.sine,
            std::abs(o.cosTheta * t.cosine - o.sinTheta * t.sine)};
}

float HairBxDF::LobeAzimuth(int p, float gamma_t) const {
    return 2 * float(p) * gamma_t - 2 * gamma_o_ + float(p) * Pi;
}

/// M_p N_p of [Chiang et al. 2016, eq. 4, 6].
float HairBxDF::Density(int p, const Outgoing& o, Vec3 wi, float phi) const {
    const Longitudinal& l = longitudinal_[size_t(std::min(p, 2))];
    const Inclination t = Tilted(p, o);
    const float cosTheta_i = SafeSqrt(1 - Sqr(wi.x));
    // [d'Eon et al. 2011, eq. 7], with exp(cos(theta_i + theta_o) / v) taken out of all factors, and the
    // cosine less one as a square so that narrow lobes keep their digits.
    const float distance2 = Sqr(cosTheta_i - t.cosine) + Sqr(wi.x + t.sine);
    const float M =
        BesselI0Scaled(cosTheta_i * t.cosine * l.inverseV) * Exp(-0.5f * distance2 * l.inverseV) * l.norm;
    if (p == kLast) return M * Inv2Pi;
    const float x = WrapAngle(phi - LobeAzimuth(p, o.gamma_t)), e = Exp(-std::abs(x) / s_);
    return M * logisticNorm_ * e / (s_ * Sqr(1 + e));
}

HairBxDF::Scattered HairBxDF::Scatter(const Outgoing& o, Vec3 wi) const {
    const float phi = ATan2(wi.z, wi.y) - o.phi;
    Scattered sum;
    for (int p = 0; p < kNumFibrePaths; ++p) {
        const float density = Density(p, o, wi, phi);
        sum.f += o.A[size_t(p)] * density;
        sum.pdf += o.weights[size_t(p)] * density;
    }
    return sum;
}

float HairBxDF::PdfOf(const Outgoing& o, Vec3 wi) const {
    const float phi = ATan2(wi.z, wi.y) - o.phi;
    float pdf = 0;
    for (int p = 0; p < kNumFibrePaths; ++p) pdf += o.weights[size_t(p)] * Density(p, o, wi, phi);
    return pdf;
}

bool HairBxDF::IsAskedFor(Vec3 wo, Vec3 wi, const BxDFContext& context) {
    if (wo.z == 0 || wi.z == 0) return false;
    return Any(context.sides, SameHemisphere(wo, wi) ? Lobes::Reflection : Lobes::Transmission);
}

BxDFValue HairBxDF::Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    if (!IsAskedFor(wo, wi, context)) return {};
    const Scattered s = Scatter(At(wo), wi);
    // The density of the way back costs as much again.
    return {s.f / AbsCosTheta(wi), s.pdf, context.needsPdf ? PdfOf(At(wi), wo) : 0.f};
}

float HairBxDF::Pdf(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    return IsAskedFor(wo, wi, context) ? PdfOf(At(wo), wi) : 0.f;
}

std::optional<BxDFSample> HairBxDF::Sample(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const {
    if (wo.z == 0) return std::nullopt;
    const Outgoing o = At(wo);
    float uPhi;
    const int p = SampleDiscrete(o.weights, u.lobe, nullptr, &uPhi);
    if (p < 0) return std::nullopt;

    // The inclination: a direction about the axis of the cone, turned [d'Eon et al. 2013, sec. 3.3].
    const Longitudinal& l = longitudinal_[size_t(std::min(p, 2))];
    const Inclination t = Tilted(p, o);
    const float most = Exp(-2 * l.inverseV);
    const float cosAxis =
        std::clamp(1 + l.v * std::log(u.direction.x + (1 - u.direction.x) * most), -1.f, 1.f);
    const float sinAxis = SafeSqrt(1 - Sqr(cosAxis));
    const float sinTheta_i =
        std::clamp(-cosAxis * t.sine + sinAxis * std::cos(2 * Pi * u.direction.y) * t.cosine, -1.f, 1.f);
    const float cosTheta_i = SafeSqrt(1 - Sqr(sinTheta_i));

    // The azimuth: uniform for the longest paths, else the inverse of the logistic between -pi and pi.
    float phi = o.phi;
    if (p == kLast) {
        phi += 2 * Pi * uPhi;
    } else {
        const float x = 2 * s_ * std::atanh((2 * uPhi - 1) / logisticNorm_);
        phi += LobeAzimuth(p, o.gamma_t) + std::clamp(x, -Pi, Pi);
    }
    const Vec3 wi(sinTheta_i, cosTheta_i * std::cos(phi), cosTheta_i * std::sin(phi));
    if (!IsAskedFor(wo, wi, context)) return std::nullopt;
    const Scattered s = Scatter(o, wi);
    // Far out in the tails of the numbers the quotient overflows.
    if (!(s.pdf > 1e-30f)) return std::nullopt;
    const bool reflects = SameHemisphere(wo, wi);
    return BxDFSample{.wi = wi,
                      .weight = s.f / s.pdf,
                      .pdf = s.pdf,
                      .pdfReverse = context.needsPdf ? PdfOf(At(wi), wo) : 0.f,
                      .lobe = reflects ? Lobes::GlossyReflection : Lobes::GlossyTransmission};
}

SampledSpectrum HairBxDF::SigmaAFromReflectance(SampledSpectrum reflectance, float beta_n) {
    const float b = beta_n;
    const float scale = 5.969f + b * (-0.215f + b * (2.532f + b * (-10.73f + b * (5.574f + b * 0.245f))));
    return Map(reflectance, [&](float c) { return std::min(Sqr(std::log(c) / scale), 1e6f); });
}

RGB HairBxDF::SigmaAFromMelanin(float eumelanin, float pheomelanin) {
    return eumelanin * RGB(0.419f, 0.697f, 1.37f) + pheomelanin * RGB(0.187f, 0.4f, 1.05f);
}

static_assert(std::is_trivially_destructible_v<HairBxDF>);

}  // namespace lacquer
