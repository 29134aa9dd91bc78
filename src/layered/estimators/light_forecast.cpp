#include "layered/estimators/light_forecast.h"

#include "layered/slopes/facet_map.h"
#include "layered/slopes/facet_slopes.h"
#include "pbrt/scattering/microfacet.h"

namespace lacquer::layered {
namespace {

constexpr float kMinCos2U = 1e-3f;  ///< of a refraction; below it, light counts as reflected totally

/// Twice the variance of the slope along an axis, the mean of both axes.
float SquaredAlpha(const MicrofacetSurface& surface) {
    return 0.5f * (Sqr(surface.alphaX) + Sqr(surface.alphaY));
}
/// Index behind a boundary over the one before it, seen from w.
float IndexBehind(const MicrofacetSurface& surface, Vec3 w) {
    return w.z > 0 ? surface.eta : 1 / surface.eta;
}

/// What the typical visible facet makes of a direction outside.
struct Entry {
    Vec3 u;         ///< inside, turned up; see facet_map.h. Not quite unit where it is kept from the horizon
    float stretch;  ///< of u's slope by the facet's
    float squaredAlpha, grazing;
    bool reflectsTotally;
};

/// As FacetMap::BoundedDeflection(), with fewer roots and quotients: a forecast has to cost next to nothing.
/// @param eta  index inside over index outside
Entry Enter(Vec3 w, float eta, float squaredAlpha) {
    constexpr float kMinCos2W = 1e-6f, kMinZ = 0.05f;
    const float z2 = std::max(w.z * w.z, kMinCos2W), sin2 = 1 - w.z * w.z;
    // The mean of (1 + r x)+ exp(-x^2/2), with r^2 = alpha^2 tan^2 / 2, is r / (1 + tilt); see
    // half_vector.cpp. With sqrt(1 + 0.637 r^2) for 1 + tilt it is off by 5 % at most.
    const float halfAlpha2 = 0.5f * squaredAlpha,
                shift = halfAlpha2 / std::sqrt(z2 + 0.637f * halfAlpha2 * sin2);
    // The facet's normal h = (shift w.x, shift w.y, 1), whose length goes into all that follows.
    const float length2 = 1 + shift * shift * sin2, over = 1 / eta;
    const float cosW = std::max(shift * sin2 + w.z, kMinZ);
    const float cos2U = length2 - (length2 - cosW * cosW) * Sqr(over);
    const float cosU = std::sqrt(std::max(cos2U, kMinCos2U));
    const float scale = (cosW - eta * cosU) / length2, planar = over * (1 - scale * shift);
    return {{planar * w.x, planar * w.y, std::max(over * (w.z - scale), kMinZ)},
            -scale * over,
            squaredAlpha,
            halfAlpha2 * sin2 / z2,
            cos2U < kMinCos2U};
}

/// What the smooth boundary makes of it.
Entry EnterSmooth(Vec3 w, float eta, float squaredAlpha) {
    const float over = 1 / eta, cosU = std::sqrt(std::max(1 - (1 - w.z * w.z) * Sqr(over), kMinCos2U));
    return {{over * w.x, over * w.y, cosU}, cosU - over * w.z, squaredAlpha, 0, false};
}
/// A direction that is at the middle facet as it comes.
Entry Outside(Vec3 w) { return {w, 0, 0, 0, false}; }

/// @param eta     index on the side of b over index on the side of a, -1 for a reflection
/// @param alpha2  of the facets that join both
/// @param slopes  theirs, null for those of an unperturbed normal
void SetForecast(const Entry& a, const Entry& b, float eta, float alpha2, const RelativeSlopes* slopes,
                 LightForecast* forecast) {
    const JoiningFacet joining(eta, a.u, b.u, 0.05f * std::abs(eta - 1));
    const Slope facet = slopes ? slopes->Of(joining.FacetSlope()) : joining.FacetSlope();
    forecast->squaredSlope = Dot(facet, facet);
    forecast->variance = alpha2 + Sqr(joining.OverSum()) * (Sqr(a.stretch) * a.squaredAlpha +
                                                            Sqr(eta * b.stretch) * b.squaredAlpha);
    forecast->exponent = forecast->squaredSlope / forecast->variance;
    forecast->grazing = std::max(a.grazing, b.grazing);
    forecast->reflectsTotally = a.reflectsTotally || b.reflectsTotally;
    forecast->cosines = {a.u.z, b.u.z};
}

// ---- With covariances -------------------------------------------------------------------------------------

/// Facets as a forecast sees them.
struct TurnedFacets {
    RelativeSlopes slopes;
    Vec3 normal;
    Symmetric2 covariance;
    float squaredAlpha;  ///< the larger one

    TurnedFacets(const StackInterface& interface, const MicrofacetSurface& surface)
        : slopes(interface),
          normal(interface.hasOwnFrame ? interface.frame.z : Vec3(0, 0, 1)),
          covariance(FacetCovariance(interface, surface)),
          squaredAlpha(Sqr(std::max(surface.alphaX, surface.alphaY))) {}
};

/// A direction that goes in through facets, or one that is at the middle facet as it comes (facets: null).
struct TurnedEnd {
    const TurnedFacets* facets;
    Vec3 w;     ///< turned up
    float eta;  ///< index inside over index outside
    Slope spread;
    float grazing = 0;

    TurnedEnd(const TurnedFacets* metFacets, Vec3 outside, float index)
        : facets(metFacets), w(outside), eta(index) {
        constexpr float kMinCos = 1e-3f;
        if (!facets) return;
        const Slope view = facets->slopes.View(w, kMinCos);
        spread = facets->covariance * view;
        grazing = Dot(view, spread);
    }
    /// False where the interface scatters nothing.
    bool IsAboveHorizon() const { return !facets || Dot(facets->normal, w) > 0; }
    /// As EnterSmooth(), about the perturbed normal.
    Entry Smooth() const {
        constexpr float kMinZ = 0.05f;
        if (!facets) return Outside(w);
        const float over = 1 / eta, cosW = std::max(Dot(facets->normal, w), kMinZ);
        const float cosU = std::sqrt(std::max(1 - (1 - cosW * cosW) * Sqr(over), kMinCos2U));
        const float stretch = cosU - over * cosW;
        Vec3 u = over * w + stretch * facets->normal;
        u.z = std::max(u.z, kMinZ);
        return {u, stretch, facets->squaredAlpha, grazing, false};
    }
    /// Relative slope of the typical visible facet, as in Enter().
    Slope TypicalFacet() const { return spread * (1 / std::sqrt(1 + 0.637f * grazing)); }
};

/// What the typical visible facet makes of an end.
struct TurnedEntry {
    LinearDeflection deflection;
    Matrix2 slopePerFacet;  ///< derivative of the facet's slope by its relative slope
    bool reflectsTotally = false;

    explicit TurnedEntry(const TurnedEnd& end) : deflection() {
        deflection.u = end.w;
        if (!end.facets) return;
        const Slope facet = end.TypicalFacet(), slope = end.facets->slopes.ToStack(facet);
        const FacetMap map(end.w, end.eta);
        reflectsTotally = !map.IsFarFromTotalReflection(slope, {}, 0);
        deflection = map.BoundedDeflection(slope);
        slopePerFacet = end.facets->slopes.StackPer(facet);
    }
};

/// ForecastLight() for any covariances and normals.
/// @param eta  index on the side of b over index on the side of a, -1 for a reflection
void SetTurnedForecast(const TurnedEnd& a, const TurnedEnd& b, const TurnedFacets& middle, float eta,
                       LightForecast* forecast) {
    // Where facets that are spread as widely to all sides do not reach, these do not either.
    constexpr float kFarOff = 12;
    if (!a.IsAboveHorizon() || !b.IsAboveHorizon()) {
        forecast->exponent = Infinity;
        return;
    }
    SetForecast(a.Smooth(), b.Smooth(), eta, middle.squaredAlpha, &middle.slopes, forecast);
    if (forecast->exponent > kFarOff) return;

    const TurnedEntry in(a), out(b);
    forecast->reflectsTotally = in.reflectsTotally || out.reflectsTotally;
    forecast->cosines = {in.deflection.u.z, out.deflection.u.z};
    Slope facet;
    Symmetric2 covariance = middle.covariance;
    const auto add = [&](const TurnedEnd& end, const TurnedEntry& entry, float index, Vec3 other) {
        if (!end.facets) return;
        const JoiningFacet joining(index, other, entry.deflection.u, 0.05f * std::abs(index - 1));
        facet = middle.slopes.Of(joining.FacetSlope());
        const Matrix2 j =
            middle.slopes.PerStack(facet) * joining.OverFacetOfU(entry.deflection) * entry.slopePerFacet;
        covariance = covariance + j.PushForward(end.facets->covariance);
    };
    add(b, out, eta, in.deflection.u);
    add(a, in, 1 / eta, out.deflection.u);
    constexpr float kMinExponent = 1e-3f;
    forecast->squaredSlope = Dot(facet, facet);
    forecast->exponent = 0.5f * Dot(facet, covariance.Inverse() * facet);
    forecast->variance =
        forecast->exponent > kMinExponent ? forecast->squaredSlope / forecast->exponent : covariance.Trace();
}

/// Share of the light along u that a rough boundary sends back, seen from its denser side: Fresnel's before
/// the critical angle, all beyond it, and the facets blur the edge.
float InternalReflectance(float cosU, float eta, float width) {
    constexpr float kSteepness = 1.3f, kSharpest = 0.02f;
    const float cosCritical = std::sqrt(1 - 1 / Sqr(eta)), straight = Sqr((eta - 1) / (eta + 1));
    const float steps = kSteepness * (cosU - cosCritical) / (kSharpest + width);
    return straight + (1 - straight) * 0.5f * (1 - steps / std::sqrt(1 + steps * steps));
}

}  // namespace

bool ForecastLight(const Stack& stack, Vec3 wo, Vec3 wi, float maxExponent, LightForecast* forecast) {
    const int last = stack.Last(), first = stack.OuterTowards(wi), step = wi.z > 0 ? 1 : -1;
    const bool isReflection = SameHemisphere(wo, wi);
    if (last < 1 || (!isReflection && last > 2)) return false;
    const int exit = isReflection ? first : last - first;
    const MicrofacetSurface *light = FacetsOf(stack.interfaces[size_t(first)]),
                            *middle = FacetsOf(stack.interfaces[size_t(first + step)]),
                            *camera = FacetsOf(stack.interfaces[size_t(exit)]);
    if (!light || !middle || !camera || light->eta == 0 || camera->eta == 0) return false;

    // The directions at the middle facet. Straight through two boundaries, that is the one where light
    // leaves.
    const bool entersTwice = isReflection || last == 2;
    const float eta = isReflection ? -1 : wi.z > 0 ? middle->eta : 1 / middle->eta;
    const float etaIn = IndexBehind(*light, wi), etaOut = entersTwice ? IndexBehind(*camera, wo) : 1;
    const auto at = [&](int k) -> const StackInterface& { return stack.interfaces[size_t(k)]; };
    if (!IsIsotropic(at(first), *light) || !IsIsotropic(at(first + step), *middle) ||
        !IsIsotropic(at(exit), *camera)) {
        if (!RelativeSlopes::ExistFor(at(first)) || !RelativeSlopes::ExistFor(at(first + step)) ||
            !RelativeSlopes::ExistFor(at(exit)))
            return false;
        const TurnedFacets facetsIn(at(first), *light), facetsOut(at(exit), *camera),
            facets(at(first + step), *middle);
        SetTurnedForecast({&facetsIn, Upward(wi), etaIn},
                          {entersTwice ? &facetsOut : nullptr, Upward(wo), etaOut}, facets, eta, forecast);
        return true;
    }
    const float alpha2 = SquaredAlpha(*middle), alphaIn2 = SquaredAlpha(*light),
                alphaOut2 = SquaredAlpha(*camera);
    const Vec3 w = Upward(wi), v = Upward(wo);
    // Visible facets turn towards the direction by 1.25 deviations at most, both ends together by less than
    // 1.77 of the sum: far off the lobe, those of the smooth boundary tell as much and take a third of the
    // time. An exponent is half of a squared number of deviations; the root of the largest one that matters
    // lies below its tangent at 3.
    const float farOff = Sqr(0.289f * maxExponent + 0.866f + 1.25f);
    SetForecast(EnterSmooth(w, etaIn, alphaIn2), entersTwice ? EnterSmooth(v, etaOut, alphaOut2) : Outside(v),
                eta, alpha2, nullptr, forecast);
    if (forecast->exponent > farOff) return true;
    SetForecast(Enter(w, etaIn, alphaIn2), entersTwice ? Enter(v, etaOut, alphaOut2) : Outside(v), eta,
                alpha2, nullptr, forecast);
    return true;
}

float LightOfLongerPaths(const LightForecast& f, const MicrofacetSurface& coat,
                         const MicrofacetSurface& base) {
    constexpr float kScale = 1.6f, kPerExponent = 1.4f, kLargest = 20;
    const float added = SquaredAlpha(base) + SquaredAlpha(coat), width = std::sqrt(added);
    const float reflectance = 0.5f * (InternalReflectance(f.cosines[0], coat.eta, width) +
                                      InternalReflectance(f.cosines[1], coat.eta, width));
    const float wider = f.squaredSlope / (f.variance + added), area = f.variance / (f.variance + added);
    // The tails of GGX fall by the fourth power of the slope.
    const float tails = (1 + f.exponent) / (1 + wider);
    const float fall = base.model == MicrofacetModel::Beckmann
                           ? std::exp(std::min(kPerExponent * (f.exponent - wider), kLargest))
                           : tails * tails * tails;
    return kScale * fall * reflectance * area * std::sqrt(area);
}

float OnePassExponent(const std::array<const MicrofacetSurface*, 3>& facets, Vec3 wo, Vec3 wi) {
    const float eta0 = facets[0]->eta, eta1 = facets[1]->eta;
    const auto enter = [&](Vec3 w, float* variance) {
        const Entry first = Enter(w, eta0, SquaredAlpha(*facets[0])),
                    second = Enter(first.u, eta1, SquaredAlpha(*facets[1]));
        *variance +=
            Sqr(second.stretch) * second.squaredAlpha + Sqr(first.stretch / eta1) * first.squaredAlpha;
        return second.u;
    };
    float variance = 0;
    const Vec3 u = enter(wi, &variance), v = enter(wo, &variance);
    const JoiningFacet joining(-1, u, v);
    return Dot(joining.FacetSlope(), joining.FacetSlope()) /
           (SquaredAlpha(*facets[2]) + Sqr(joining.OverSum()) * variance);
}

}  // namespace lacquer::layered
