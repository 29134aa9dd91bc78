// Scattering once by a rough boundary, for any distribution of microfacet normals.
#pragma once

#include <concepts>
#include <type_traits>

#include "pbrt/scattering/beckmann.h"
#include "pbrt/scattering/fresnel.h"
#include "pbrt/scattering/trowbridge_reitz.h"

namespace lacquer {

/// Which distribution a rough boundary has.
enum class MicrofacetModel { TrowbridgeReitz, Beckmann };

/// A distribution of normals with Smith's shadowing; see TrowbridgeReitz for the meaning of the members.
template <class T>
concept MicrofacetDistribution = requires(const T d, Vec3 w, Point2 u, Rng& rng) {
    T(0.1f, 0.2f);
    { d.AlphaX() } -> std::same_as<float>;
    { d.AlphaY() } -> std::same_as<float>;
    { d.D(w) } -> std::same_as<float>;
    { d.ProjectedArea(w) } -> std::same_as<float>;
    { d.SampleVisible(w, u) } -> std::same_as<Vec3>;
    { d.SampleVisible(w, u, rng) } -> std::same_as<Vec3>;
    { d.InvertVisible(w, w) } -> std::same_as<Point2>;
};
static_assert(MicrofacetDistribution<TrowbridgeReitz> && MicrofacetDistribution<Beckmann>);

/// The name of a distribution.
template <MicrofacetDistribution Distribution>
inline constexpr MicrofacetModel kModelOf =
    std::is_same_v<Distribution, Beckmann> ? MicrofacetModel::Beckmann : MicrofacetModel::TrowbridgeReitz;

/// Boundaries whose alphas are both below this are perfectly smooth.
inline constexpr float kSmoothAlpha = 1e-3f;

/// alpha of a `roughness` that the user typed with remaproughness.
inline float RoughnessToAlpha(float roughness) { return SafeSqrt(roughness); }

/// Both alphas of a boundary, made safe: each in [1e-4, 1e3], NaN and negative ones as the lower end.
struct Alphas {
    float x, y;
    Alphas(float alphaX, float alphaY) : x(ClampAlpha(alphaX)), y(ClampAlpha(alphaY)) {}
    bool IsSmooth() const { return std::max(x, y) < kSmoothAlpha; }
    /// The alphas that path regularisation uses instead.
    Alphas Regularized() const { return {Widen(x), Widen(y)}; }

  private:
    static float ClampAlpha(float alpha) { return alpha > 1e-4f ? std::min(alpha, 1e3f) : 1e-4f; }
    static float Widen(float alpha) { return alpha < 0.3f ? std::clamp(2 * alpha, 0.1f, 0.3f) : alpha; }
};

/// Fraction of the microfacets with visible normals that w sees [Smith 1967]: 1/(1 + Lambda(w)).
template <MicrofacetDistribution Distribution>
float MaskingG1(const Distribution& d, Vec3 w) {
    return std::abs(w.z) / d.ProjectedArea(w);
}

/// Density of the normals that w sees, D(wm) max(0, w.wm) G1(w)/|cos|, over solid angle of wm [1/sr].
/// @param w, wm  unit, on the same side of the surface for facets that w can see  [Heitz 2018] eq. 3
template <MicrofacetDistribution Distribution>
float PdfVisible(const Distribution& d, Vec3 w, Vec3 wm) {
    return d.D(wm) * std::max(0.f, Dot(w, wm)) / d.ProjectedArea(w);
}

/// The parts of scattering at facets that turn wo into wi, without Fresnel's factor. All zero where no facet
/// does.
struct MicrofacetTerms {
    Vec3 wm{0, 0, 1};          ///< normal of those facets, unit, wm.z >= 0
    float value = 0;           ///< what Fresnel's factor and eta^2 are multiplied with to give f [1/sr]
    float pdf = 0;             ///< density of wi for visible normals [1/sr]
    float pdfReverse = 0;      ///< density of wo, where wi is the given one [1/sr]
    float shadowingRatio = 0;  ///< G(wo, wi)/G1(wo): value |cos theta_i| / pdf, cancelled
};

/// Shadowing of wo and wi together, height-correlated: G = 1/(1 + Lambda(wo) + Lambda(wi)), in two forms.
template <MicrofacetDistribution Distribution>
struct Shadowing {
    float areaO, areaI;  ///< ProjectedArea of each
    float overCosines;   ///< G / (|cos theta_o| |cos theta_i|), finite unless both graze
    float ratio;         ///< G / G1(wo)
    Shadowing(const Distribution& d, Vec3 wo, Vec3 wi) {
        // With A = |cos|(1 + Lambda), G/(co ci) is 1/(Ao ci + Ai co - co ci), free of quotients by cosines.
        const float co = std::abs(wo.z), ci = std::abs(wi.z);
        areaO = d.ProjectedArea(wo);
        areaI = d.ProjectedArea(wi);
        overCosines = 1 / (areaO * ci + (areaI - ci) * co);
        ratio = areaO * ci * overCosines;
    }
};

/// Mirror reflection at facets [Walter et al. 2007, eq. 20]. wo and wi must be on the same side.
template <MicrofacetDistribution Distribution>
[[gnu::always_inline]] inline MicrofacetTerms ReflectionTerms(const Distribution& d, Vec3 wo, Vec3 wi) {
    const Vec3 sum = wo + wi;
    const float length2 = LengthSquared(sum);
    if (!(length2 > 0)) return {};
    const Vec3 wm = sum * std::copysign(1 / std::sqrt(length2), sum.z);
    const Shadowing<Distribution> g(d, wo, wi);
    const float density = 0.25f * d.D(wm);
    // PdfVisible / (4 |wo.wm|), with the dot product cancelled.
    return {wm, density * g.overCosines, density / g.areaO, density / g.areaI, g.ratio};
}

/// Refraction at facets [Walter et al. 2007, eq. 21]. wo and wi must be on opposite sides.
/// @param etap  index on the side of wi over index on the side of wo, > 0 and not 1
/// `value` is that of importance: radiance is divided by etap^2.
template <MicrofacetDistribution Distribution>
[[gnu::always_inline]] inline MicrofacetTerms TransmissionTerms(const Distribution& d, Vec3 wo, Vec3 wi,
                                                                float etap) {
    // The normal lies along wo + etap wi [Walter et al. 2007, eq. 16].
    const Vec3 sum = wo + etap * wi;
    const float length2 = LengthSquared(sum);
    if (!(length2 > 0)) return {};
    const Vec3 wm = sum * std::copysign(1 / std::sqrt(length2), sum.z);
    const float dotO = Dot(wo, wm), dotI = Dot(wi, wm);
    // No light passes through the backs of facets.
    if (!(dotO * wo.z > 0) || !(dotI * wi.z > 0)) return {};
    const Shadowing<Distribution> g(d, wo, wi);
    // Solid angle of wm per solid angle of wi [Walter et al. 2007, eq. 17]: |wi.wm| / (wi.wm + wo.wm/etap)^2,
    // where the denominator is the length of the sum over etap.
    const float jacobian = std::abs(dotI) * etap * etap / length2;
    const float common = d.D(wm) * std::abs(dotO) * jacobian;
    // Seen from wi the two dot products exchange their places, and the index is the inverse.
    return {wm, common * g.overCosines, common / g.areaO, common / (Sqr(etap) * g.areaI), g.ratio};
}

}  // namespace lacquer
