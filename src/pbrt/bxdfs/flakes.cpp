#include "pbrt/bxdfs/flakes.h"

#include <array>
#include <cmath>
#include <type_traits>

namespace lacquer {
namespace {

/// The share of the normals whose slopes, in units of alpha, are below r.
template <MicrofacetDistribution Distribution>
float RadialShare(float r) {
    if constexpr (kModelOf<Distribution> == MicrofacetModel::Beckmann) return -std::expm1(-r * r);
    return std::isinf(r * r) ? 1 : r * r / (1 + r * r);
}
/// Its inverse.
template <MicrofacetDistribution Distribution>
float RadiusOfShare(float share) {
    if constexpr (kModelOf<Distribution> == MicrofacetModel::Beckmann) return std::sqrt(-Log(1 - share));
    return std::sqrt(share / (1 - share));
}

/// Alphas with the kernel's variance of slopes, roughness^2/6 in each direction, beside that of the flakes,
/// which is alpha^2/2 for the distribution of Beckmann.
Alphas WithRoughness(Alphas alphas, float roughness) {
    const float added = Sqr(roughness) / 3;
    return {std::sqrt(Sqr(alphas.x) + added), std::sqrt(Sqr(alphas.y) + added)};
}

}  // namespace

template <MicrofacetDistribution Distribution>
Slope SlopeOfFlake(const Flake& flake, const Distribution& normals) {
    const float r = RadiusOfShare<Distribution>(flake.radial);
    const auto [sin, cos] = SinCosOfTurn(flake.turn);
    return {r * cos * normals.AlphaX(), r * sin * normals.AlphaY()};
}

template <MicrofacetDistribution Distribution>
FlakesBxDF<Distribution>::FlakesBxDF(Alphas alphas, float roughness, const FlakeOptics& optics)
    : flakes_(alphas.x, alphas.y),
      facets_(WithRoughness(alphas, roughness).x, WithRoughness(alphas, roughness).y),
      roughness_(roughness),
      optics_(optics) {}

template <MicrofacetDistribution Distribution>
FlakesBxDF<Distribution>::FlakesBxDF(Alphas alphas, float roughness, const FlakeOptics& optics,
                                     const FlakesInWindow& flakes)
    : FlakesBxDF(alphas, roughness, optics) {
    discrete_ = flakes;
    count_ = flakes.field.Count(flakes.window);
    // The share of points that one of so many flakes covers. Its mean over numbers of flakes that vary as
    // those of independent ones do is 1 - exp(-mean number times areaShare), however large the window.
    const float missed = 1 - std::min(flakes.areaShare, 1.f);
    const float coverage = count_ == 0 ? 0.f : 1 - std::pow(missed, float(count_));
    const float reflectance = optics.MeanReflectance(1).Average();
    passing_ = flakes.sheetCoverage.value_or(coverage);
    above_ = SideWith(true, coverage, reflectance);
    below_ = flakes.sheetCoverage ? SideWith(false, passing_, reflectance) : above_;
}

template <MicrofacetDistribution Distribution>
FlakesBxDF<Distribution>::FlakesBxDF(Alphas alphas, float roughness, const FlakeOptics& optics,
                                     float coverage)
    : FlakesBxDF(alphas, roughness, optics) {
    passing_ = coverage;
    above_ = below_ = SideWith(false, coverage, optics.MeanReflectance(1).Average());
}

// By the reflectance at normal incidence; no less than a half, for at grazing angles everything is a mirror.
template <MicrofacetDistribution Distribution>
typename FlakesBxDF<Distribution>::Side FlakesBxDF<Distribution>::SideWith(bool isCounted, float coverage,
                                                                           float reflectance) const {
    const float reflected = coverage * std::clamp(reflectance, 0.5f, 1.f);
    const float passed = 1 - passing_ * (optics_.Transmits() ? std::clamp(reflectance, 0.f, 0.9f) : 1.f);
    return {isCounted, coverage, coverage > 0 ? reflected / (reflected + passed) : 0.f};
}

template <MicrofacetDistribution Distribution>
Lobes FlakesBxDF<Distribution>::Flags() const {
    return (above_.coverage > 0 || below_.coverage > 0 ? Lobes::GlossyReflection : Lobes::None) |
           (passing_ < 1 || optics_.Transmits() ? Lobes::SpecularTransmission : Lobes::None);
}

template <MicrofacetDistribution Distribution>
float FlakesBxDF<Distribution>::ReflectionProbability(const Side& side, const BxDFContext& context) const {
    if (!Any(context.sides, Lobes::Transmission)) return side.coverage > 0 ? 1 : 0;
    return Any(context.sides, Lobes::Reflection) ? side.reflectionProbability : 0;
}

template <MicrofacetDistribution Distribution>
FlakeNormals FlakesBxDF<Distribution>::NormalsAbout(Slope slope) const {
    constexpr float kMargin = 1 + 1e-4f;
    const float x = slope.x / flakes_.AlphaX(), y = slope.y / flakes_.AlphaY(), r = std::sqrt(x * x + y * y);
    const float reach = kMargin * roughness_ / std::min(flakes_.AlphaX(), flakes_.AlphaY());
    FlakeNormals normals;
    normals.radialLow = RadialShare<Distribution>(std::max(r - reach, 0.f)) * (2 - kMargin);
    normals.radialHigh = RadialShare<Distribution>(r + reach) * kMargin;
    if (r > reach) {
        const float turn = std::atan2(y, x) * Inv2Pi;
        normals.turn = turn < 0 ? turn + 1 : turn;
        normals.halfTurn = std::asin(reach / r) * Inv2Pi * kMargin + 1e-6f;
    }
    return normals;
}

template <MicrofacetDistribution Distribution>
typename FlakesBxDF<Distribution>::Facets FlakesBxDF<Distribution>::FacetsAbout(Slope slope, float cosTheta_d,
                                                                                bool isCounted) const {
    if (!isCounted) {
        const Vec3 wm = DirectionOf(slope);
        return {facets_.D(wm) * Sqr(wm.z * wm.z), optics_.MeanReflectance(cosTheta_d)};
    }
    std::array<float, FlakeOptics::kThicknesses> byKind{};
    const float overReach2 = 1 / Sqr(roughness_);
    const auto numKinds = uint64_t(optics_.NumKinds());
    discrete_->field.ForEach(discrete_->window, NormalsAbout(slope), [&](const Flake& flake) {
        const Slope difference = slope - SlopeOfFlake(flake, flakes_);
        const float share = 1 - Dot(difference, difference) * overReach2;
        if (share > 0) byKind[flake.bits % numKinds] += share;
    });
    float sum = 0;
    SampledSpectrum reflected(0);
    for (int kind = 0; kind < optics_.NumKinds(); ++kind)
        if (const float ofKind = byKind[size_t(kind)]; ofKind > 0) {
            sum += ofKind;
            reflected += ofKind * optics_.Reflectance(cosTheta_d, kind);
        }
    if (!(sum > 0)) return {};
    return {sum * 2 * InvPi * overReach2 / float(count_), reflected / sum};
}

template <MicrofacetDistribution Distribution>
BxDFValue FlakesBxDF<Distribution>::Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const {
    if (!SameHemisphere(wo, wi) || !Any(context.sides, Lobes::Reflection)) return {};
    const Side& side = SideOf(wo);
    if (side.coverage == 0) return {};
    const Vec3 sum = wo + wi;
    const float length2 = LengthSquared(sum);
    if (!(length2 > 0) || sum.z == 0) return {};
    const Vec3 wm = sum * std::copysign(1 / std::sqrt(length2), sum.z);
    const float cosTheta_d = std::min(AbsDot(wo, wm), 1.f);
    const Facets facets = FacetsAbout(SlopeOf(wm), cosTheta_d, side.isCounted);
    if (!(facets.density > 0) || cosTheta_d == 0) return {};
    const Shadowing<Distribution> shadowing(facets_, wo, wi);
    const float overCos3 = SlopePerSolidAngle(wm);
    // Slopes of facets have the density D cos^4; so have those that Sample() draws, whoever sees them.
    const float value = 0.25f * side.coverage * facets.density * overCos3 / wm.z * shadowing.overCosines;
    const float pdf = ReflectionProbability(side, context) * facets.density * overCos3 / (4 * cosTheta_d);
    return {value * facets.reflectance, pdf, pdf};
}

template <MicrofacetDistribution Distribution>
Slope FlakesBxDF<Distribution>::SampleFacet(bool isCounted, float pick, const BxDFRandom& u) const {
    const auto [sin, cos] = SinCosOfTurn(u.direction.x);
    if (!isCounted) {
        const float r = RadiusOfShare<Distribution>(std::min(u.direction.y, 0x1.fffffep-1f));
        return {r * cos * facets_.AlphaX(), r * sin * facets_.AlphaY()};
    }
    const int index = std::min(int(pick * float(count_)), count_ - 1);
    // The kernel's distribution function of r^2 is 2 r^2 - r^4.
    const float r = roughness_ * SafeSqrt(1 - SafeSqrt(1 - u.direction.y));
    return SlopeOfFlake(discrete_->field.Pick(discrete_->window, index), flakes_) + Slope{r * cos, r * sin};
}

template <MicrofacetDistribution Distribution>
BxDFSample FlakesBxDF<Distribution>::SampleTransmission(Vec3 wo, const BxDFRandom& u,
                                                        float probability) const {
    SampledSpectrum weight(1 - passing_);
    if (optics_.Transmits()) {
        // The plates that light meets are those that it sees; of one of them, as many as are there.
        const Vec3 w = wo.z < 0 ? -wo : wo;
        const float cosTheta_d = std::clamp(Dot(w, facets_.SampleVisible(w, u.direction)), 0.f, 1.f);
        weight = 1 - passing_ * optics_.MeanReflectance(cosTheta_d);
    }
    return {.wi = -wo,
            .weight = weight / probability,
            .pdf = probability,
            .pdfReverse = probability,
            .lobe = Lobes::SpecularTransmission};
}

template <MicrofacetDistribution Distribution>
std::optional<BxDFSample> FlakesBxDF<Distribution>::Sample(Vec3 wo, const BxDFRandom& u,
                                                           const BxDFContext& context) const {
    if (wo.z == 0) return std::nullopt;
    const Side& side = SideOf(wo);
    const float probability = ReflectionProbability(side, context);
    if (!(u.lobe < probability)) {
        if (!Any(context.sides, Lobes::Transmission) || !Any(Flags(), Lobes::Transmission))
            return std::nullopt;
        return SampleTransmission(wo, u, 1 - probability);
    }
    const Vec3 wm = DirectionOf(SampleFacet(side.isCounted, u.lobe / probability, u), wo.z);
    if (!(Dot(wo, wm) > 0)) return std::nullopt;
    const Vec3 wi = Normalize(Reflect(wo, wm));
    if (!SameHemisphere(wo, wi)) return std::nullopt;
    // The density is that of wi as it was rounded, so that it is the one that Evaluate() finds.
    const BxDFValue value = Evaluate(wo, wi, context);
    if (!(value.pdf > 0)) return std::nullopt;
    return BxDFSample{.wi = wi,
                      .weight = value.f * (AbsCosTheta(wi) / value.pdf),
                      .pdf = value.pdf,
                      .pdfReverse = value.pdfReverse,
                      .lobe = Lobes::GlossyReflection};
}

template <MicrofacetDistribution Distribution>
void FlakesBxDF<Distribution>::Regularize() {
    const Alphas alphas = Alphas(facets_.AlphaX(), facets_.AlphaY()).Regularized();
    facets_ = Distribution(alphas.x, alphas.y);
    discrete_.reset();
    above_.isCounted = below_.isCounted = false;
}

template Slope SlopeOfFlake(const Flake& flake, const TrowbridgeReitz& normals);
template Slope SlopeOfFlake(const Flake& flake, const Beckmann& normals);
template class FlakesBxDF<TrowbridgeReitz>;
template class FlakesBxDF<Beckmann>;
static_assert(std::is_trivially_destructible_v<FlakesBxDF<TrowbridgeReitz>>);

}  // namespace lacquer
