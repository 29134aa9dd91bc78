#include "layered/estimators/light_forecast.h"

#include "layered/paths/interface_path.h"
#include "layered/slopes/facet_map.h"
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
void SetForecast(const Entry& a, const Entry& b, float eta, float alpha2, LightForecast* forecast) {
    const JoiningFacet joining(eta, a.u, b.u, 0.05f * std::abs(eta - 1));
    forecast->squaredSlope = Dot(joining.FacetSlope(), joining.FacetSlope());
    forecast->variance = alpha2 + Sqr(joining.OverSum()) * (Sqr(a.stretch) * a.squaredAlpha +
                                                            Sqr(eta * b.stretch) * b.squaredAlpha);
    forecast->exponent = forecast->squaredSlope / forecast->variance;
    forecast->grazing = std::max(a.grazing, b.grazing);
    forecast->reflectsTotally = a.reflectsTotally || b.reflectsTotally;
    forecast->cosines = {a.u.z, b.u.z};
}

// ---- With covariances -------------------------------------------------------------------------------------

/// The typical visible facet of an event that the path enters by, and what it makes of the direction outside.
struct TurnedEntry {
    LinearDeflection deflection;
    Matrix2 slopePerFacet;  ///< derivative of the facet's slope by its relative slope
    float grazing;
    bool reflectsTotally;

    TurnedEntry(const PathEvent& event, Vec3 w, float eta) {
        constexpr float kMinCos = 1e-3f;
        const RelativeSlopes slopes = event.Slopes();
        const Slope s = slopes.View(w, kMinCos), cs = event.slopeCovariance * s;
        grazing = Dot(s, cs);
        // As Enter().
        const Slope facet = cs * (1 / std::sqrt(1 + 0.637f * grazing)), slope = slopes.ToStack(facet);
        const FacetMap map(w, eta);
        FacetDeflection exact;
        reflectsTotally = !map.Deflection(slope, &exact);
        deflection = map.BoundedDeflection(slope);
        slopePerFacet = slopes.StackPer(facet);
    }
};

/// ForecastLight() for any covariances and normals.
LightForecast ForecastTurned(const InterfacePath& path) {
    // Straight through two boundaries the middle facet is the one where light leaves.
    const bool entersTwice = path.numEvents == 3;
    const PathEvent &light = path.events[0], &middle = path.events[1], &camera = path.events[2];
    const RelativeSlopes slopes = middle.Slopes();
    const Vec3 w = Upward(path.wi), v = Upward(path.wo);
    const float eta = middle.transmits ? 1 / middle.eta : -1;
    const TurnedEntry in(light, w, 1 / light.eta);
    LightForecast forecast;
    forecast.grazing = in.grazing;
    forecast.reflectsTotally = in.reflectsTotally;
    forecast.cosines = {in.deflection.u.z, v.z};

    const auto addEntry = [&](const PathEvent& event, const TurnedEntry& entry, float index, Vec3 other,
                              Slope* facet, Symmetric2* covariance) {
        const JoiningFacet joining(index, other, entry.deflection.u, 0.05f * std::abs(index - 1));
        *facet = slopes.Of(joining.FacetSlope());
        const Matrix2 j =
            slopes.PerStack(*facet) * joining.OverFacetOfU(entry.deflection) * entry.slopePerFacet;
        *covariance = *covariance + j.PushForward(event.slopeCovariance);
    };
    Slope facet;
    Symmetric2 covariance = middle.slopeCovariance;
    if (entersTwice) {
        const TurnedEntry out(camera, v, camera.eta);
        addEntry(camera, out, eta, in.deflection.u, &facet, &covariance);
        addEntry(light, in, 1 / eta, out.deflection.u, &facet, &covariance);
        forecast.grazing = std::max(forecast.grazing, out.grazing);
        forecast.reflectsTotally |= out.reflectsTotally;
        forecast.cosines[1] = out.deflection.u.z;
    } else {
        addEntry(light, in, 1 / eta, v, &facet, &covariance);
    }
    constexpr float kMinExponent = 1e-3f;
    forecast.squaredSlope = Dot(facet, facet);
    forecast.exponent = 0.5f * Dot(facet, covariance.Inverse() * facet);
    forecast.variance =
        forecast.exponent > kMinExponent ? forecast.squaredSlope / forecast.exponent : covariance.Trace();
    return forecast;
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

bool ForecastLight(const Stack& stack, Vec3 wo, Vec3 wi, LightForecast* forecast) {
    const int last = stack.Last(), first = stack.OuterTowards(wi), step = wi.z > 0 ? 1 : -1;
    const bool isReflection = SameHemisphere(wo, wi);
    if (last < 1 || (!isReflection && last > 2)) return false;
    const int exit = isReflection ? first : last - first;
    const MicrofacetSurface *light = FacetsOf(stack.interfaces[size_t(first)]),
                            *middle = FacetsOf(stack.interfaces[size_t(first + step)]),
                            *camera = FacetsOf(stack.interfaces[size_t(exit)]);
    if (!light || !middle || !camera || light->eta == 0 || camera->eta == 0) return false;
    const auto isIsotropic = [&](int k, const MicrofacetSurface& facets) {
        return IsIsotropic(stack.interfaces[size_t(k)], facets);
    };
    if (!isIsotropic(first, *light) || !isIsotropic(first + step, *middle) || !isIsotropic(exit, *camera)) {
        InterfacePath path;
        if (!FindShortestPath(stack, wo, wi, InterfacePath::kMaxShortestEvents, &path)) return false;
        *forecast = ForecastTurned(path);
        return true;
    }

    // The directions at the middle facet. Straight through two boundaries, that is the one where light
    // leaves.
    const bool entersTwice = isReflection || last == 2;
    const float eta = isReflection ? -1 : wi.z > 0 ? middle->eta : 1 / middle->eta;
    const float etaIn = IndexBehind(*light, wi), etaOut = entersTwice ? IndexBehind(*camera, wo) : 1;
    const float alpha2 = SquaredAlpha(*middle), alphaIn2 = SquaredAlpha(*light),
                alphaOut2 = SquaredAlpha(*camera);
    const Vec3 w = Upward(wi), v = Upward(wo);
    // Visible facets turn towards the direction by 1.25 deviations at most: far off the lobe, those of the
    // smooth boundary tell as much and take a third of the time.
    constexpr float kFarOff = 16;
    SetForecast(EnterSmooth(w, etaIn, alphaIn2), entersTwice ? EnterSmooth(v, etaOut, alphaOut2) : Outside(v),
                eta, alpha2, forecast);
    if (forecast->exponent > kFarOff) return true;
    SetForecast(Enter(w, etaIn, alphaIn2), entersTwice ? Enter(v, etaOut, alphaOut2) : Outside(v), eta,
                alpha2, forecast);
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
