#include "layered/estimators/query_plan.h"

#include "layered/estimators/light_forecast.h"
#include "layered/estimators/short_paths.h"
#include "layered/paths/half_vectors/shortest_path.h"
#include "layered/paths/long_paths/long_path.h"
#include "layered/slopes/facet_slopes.h"
#include "pbrt/scattering/microfacet.h"

namespace lacquer::layered {
namespace {

constexpr QueryPlan kLongPathsOnly = {PathMethod::LongPathWalk, PathMethod::LongPathWalk, 1};
constexpr QueryPlan kProductAndLongPaths = {PathMethod::Product, PathMethod::LongPathWalk, 1};
constexpr QueryPlan kConnections = {};
constexpr float kSeldom = 0.15f;     ///< smallest probability of the rest
constexpr float kMaxGrazing = 0.3f;  ///< of products of other distributions than Beckmann's

QueryPlan ProductAndConnections(float restProbability) {
    return {PathMethod::Product, PathMethod::Connection, std::clamp(restProbability, kSeldom, 1.f)};
}
/// The shortest path by product sampling if it carries enough. The rest is made as often as the root of its
/// part in the noise, which goes with its part in the light, and the more often the better the product is.
QueryPlan PlanProduct(const LightForecast& f, const MicrofacetSurface& coat, const MicrofacetSurface& base,
                      float largestRest, float smallestProbability) {
    const float rest = LightOfLongerPaths(f, coat, base);
    if (!(rest < largestRest)) return kConnections;
    return ProductAndConnections(
        std::max({1.5f * std::sqrt(rest), 1.6f * MeanAlpha(base) / MeanAlpha(coat), smallestProbability}));
}

/// Under one coat, between directions above. A walk of the long path ends where the base happens to reflect
/// into the refraction of the other side, and that is rare where the base is smooth compared with the coat or
/// where the directions are far off the lobe.
QueryPlan PlanBeckmannCoat(const MicrofacetSurface& coat, const MicrofacetSurface& base,
                           const LightForecast& f) {
    const float alphaCoat = coat.alphaX, alphaBase = base.alphaX;
    if (alphaCoat > 0.6f && f.exponent > 2) return kConnections;
    if (alphaBase >= 0.4f && f.exponent < 6) return kLongPathsOnly;
    if (!(f.grazing < 50) || !(f.exponent < 4.5f)) return kConnections;
    if (alphaCoat <= 2.5f * alphaBase && f.exponent < 4) return kProductAndLongPaths;
    // The linear models of half vectors end there.
    if (alphaCoat > 0.5f && (f.exponent > 1 || f.grazing > 1)) return kConnections;
    return PlanProduct(f, coat, base, 1.5f, alphaCoat > 0.5f ? 1.f : 0.2f);
}
/// Up to where a walk of the long path makes all light, for other facets than Beckmann's.
float MaxExponentOfLongPaths(float alphaCoat, float alphaBase) {
    if (alphaBase >= 0.35f && alphaCoat <= 1.5f * alphaBase) return 4;
    return alphaBase > 0.1f && alphaCoat <= 0.3f * alphaBase ? 2.5f : 0;
}
QueryPlan PlanOtherCoat(const MicrofacetSurface& coat, const MicrofacetSurface& base,
                        const LightForecast& f) {
    const float alphaCoat = coat.alphaX, alphaBase = base.alphaX;
    if (f.exponent < MaxExponentOfLongPaths(alphaCoat, alphaBase)) return kLongPathsOnly;
    if (!(f.exponent < 2) || !(f.grazing < kMaxGrazing)) return kConnections;
    if (alphaCoat <= 1.5f * alphaBase) return kProductAndLongPaths;
    return alphaCoat < 0.6f && f.grazing < 0.2f ? PlanProduct(f, coat, base, 1.5f, 0.2f) : kConnections;
}
/// True if no plan of PlanOtherCoat() wants these directions, whatever the forecast says.
bool NeedsNoForecast(const MicrofacetSurface& coat, const MicrofacetSurface& base, Vec3 wo, Vec3 wi) {
    if (MaxExponentOfLongPaths(coat.alphaX, base.alphaX) > 0) return false;
    const float z2 = Sqr(std::min(wo.z, wi.z));
    return coat.alphaX >= std::max(0.6f, 1.5f * base.alphaX) ||
           0.5f * Sqr(coat.alphaX) * (1 - z2) > kMaxGrazing * z2;
}
/// Anisotropic facets or perturbed normals. There is no walk for their long paths, which have the noise where
/// the base is rough; and mixtures make little of wide tails.
QueryPlan PlanTurnedCoat(const Stack& stack, Vec3 wo, Vec3 wi, const MicrofacetSurface& coat,
                         const MicrofacetSurface& base, bool isBeckmann) {
    const float alphaCoat = MeanAlpha(coat), alphaBase = MeanAlpha(base);
    const float maxCoat = isBeckmann ? 0.5f : 0.33f, maxExponent = isBeckmann ? 4.5f : 2.2f,
                maxGrazing = isBeckmann ? 5 : 0.2f;
    const float maxBase =
        isBeckmann ? std::clamp(5 * alphaCoat, 0.2f, 0.35f) : std::min(8 * alphaCoat, 0.11f);
    if (alphaCoat > maxCoat || alphaBase > maxBase) return kConnections;
    // Rough boundaries of small indices turn light by little, and facets of all slopes take part.
    if (alphaCoat > 2 * (coat.eta - 1)) return kConnections;
    LightForecast forecast;
    if (!ForecastLight(stack, wo, wi, &forecast) || forecast.reflectsTotally) return kConnections;
    if (!(forecast.exponent < maxExponent) || forecast.grazing > maxGrazing) return kConnections;
    return PlanProduct(forecast, coat, base, 1.5f, 0.2f);
}
QueryPlan PlanCoat(const Stack& stack, Vec3 wo, Vec3 wi) {
    const MicrofacetSurface *coat = FacetsOf(stack.interfaces[0]), *base = FacetsOf(stack.interfaces[1]);
    if (!coat || !base) return kConnections;
    const bool isBeckmann =
        coat->model == MicrofacetModel::Beckmann && base->model == MicrofacetModel::Beckmann;
    const bool isIsotropic =
        IsIsotropic(stack.interfaces[0], *coat) && IsIsotropic(stack.interfaces[1], *base);
    if (!isIsotropic) return PlanTurnedCoat(stack, wo, wi, *coat, *base, isBeckmann);
    if (!isBeckmann && NeedsNoForecast(*coat, *base, wo, wi)) return kConnections;
    LightForecast forecast;
    if (!ForecastLight(stack, wo, wi, &forecast) || forecast.reflectsTotally) return kConnections;
    return (isBeckmann ? PlanBeckmannCoat : PlanOtherCoat)(*coat, *base, forecast);
}

/// Straight through. Rough boundaries are too much for linear models of facets.
QueryPlan PlanTransmission(const Stack& stack, Vec3 wo, Vec3 wi) {
    bool isBeckmann = true, isIsotropic = true;
    float roughest = 0, smoothest = 1;
    for (const StackInterface& interface : stack.interfaces) {
        const MicrofacetSurface* facets = FacetsOf(interface);
        if (!facets) return kConnections;
        isBeckmann &= facets->model == MicrofacetModel::Beckmann;
        isIsotropic &= IsIsotropic(interface, *facets);
        roughest = std::max({roughest, facets->alphaX, facets->alphaY});
        smoothest = std::min(smoothest, std::max(facets->alphaX, facets->alphaY));
    }
    const float maxAlpha = isIsotropic  ? (isBeckmann ? 0.5f : 0.35f)
                           : isBeckmann ? 0.45f
                                        : std::min(8 * smoothest, 0.2f);
    if (roughest > maxAlpha) return kConnections;
    LightForecast forecast;
    if (!ForecastLight(stack, wo, wi, &forecast) || forecast.reflectsTotally) return kConnections;
    const float maxExponent = isIsotropic  ? (isBeckmann ? 4.5f : 2.5f)
                              : isBeckmann ? 3
                                           : 2.1f,
                maxGrazing = !isBeckmann   ? 0.35f
                             : isIsotropic ? Infinity
                                           : 2;
    if (forecast.exponent > maxExponent || forecast.grazing > maxGrazing) return kConnections;
    // Off the middle of the lobe the other paths carry more.
    const float share = NumOtherEstimates(stack, wo, wi, {stack.Last() + 1});
    return ProductAndConnections(share * std::exp(std::max(0.f, 1.2f * (forecast.exponent - 1))));
}

/// Two coats over metal, between directions above: the path of one pass, down to the base and up again, if
/// its lobes are of similar width and the directions in the middle of their product.
QueryPlan PlanTwoCoats(const Stack& stack, Vec3 wo, Vec3 wi) {
    constexpr float kMinAlpha = 0.03f, kMaxAlpha = 0.4f, kMaxQuotient = 4, kMinIndex = 1.15f,
                    kMinCosine = 0.3f, kMaxExponent = 1.5f;
    if (std::min(wo.z, wi.z) < kMinCosine) return kConnections;
    std::array<const MicrofacetSurface*, 3> facets;
    float smallest = 1, largest = 0;
    for (size_t k = 0; k < 3; ++k) {
        facets[k] = FacetsOf(stack.interfaces[k]);
        if (!facets[k] || facets[k]->model != MicrofacetModel::Beckmann ||
            !IsIsotropic(stack.interfaces[k], *facets[k]))
            return kConnections;
        if (k < 2 && facets[k]->eta < kMinIndex) return kConnections;
        smallest = std::min(smallest, facets[k]->alphaX);
        largest = std::max(largest, facets[k]->alphaX);
    }
    if (smallest < kMinAlpha || largest > std::min(kMaxAlpha, kMaxQuotient * smallest)) return kConnections;
    if (OnePassExponent(facets, wo, wi) > kMaxExponent) return kConnections;
    return {PathMethod::PairProduct, PathMethod::Connection, 1};
}

}  // namespace

QueryPlan ChoosePlan(const Stack& stack, Vec3 wo, Vec3 wi, int maxVertices) {
    const int last = stack.Last();
    const bool isReflection = SameHemisphere(wo, wi);
    // Where there are no longer paths, the shortest one has all the noise.
    if (maxVertices < (isReflection ? 5 : last + 3))
        return last == 1 || !isReflection ? ProductAndConnections(1) : kConnections;
    if (!isReflection) return PlanTransmission(stack, wo, wi);
    return last == 2 ? PlanTwoCoats(stack, wo, wi) : PlanCoat(stack, wo, wi);
}

// Apart, so that nothing else is in its stack frame: a walk is 20 kB, and where other variables shift it, its
// time grows by up to a tenth.
[[gnu::noinline]] SampledSpectrum EstimateByConnections(const Stack& stack, Vec3 wo, Vec3 wi,
                                                        const BxDFContext& context, int maxVertices) {
    return ConnectionWalk<WalkPolicy>(stack, context, maxVertices).Estimate(wo, wi);
}

namespace {

SampledSpectrum ProductAndRest(const QueryPlan& plan, const Stack& stack, Vec3 wo, Vec3 wi,
                               const BxDFContext& context, int maxVertices) {
    InterfacePath path;
    const ShortestPathMethod method = FindShortestPath(stack, wo, wi, maxVertices, &path)
                                          ? ShortestPathMethodFor(path)
                                          : ShortestPathMethod::None;
    if (method == ShortestPathMethod::None) return EstimateByConnections(stack, wo, wi, context, maxVertices);
    const SampledSpectrum value = EstimateShortestPath(method, path, context);
    if (maxVertices < path.numEvents + 2) return value;
    const float share = plan.restProbability;
    if (share < 1 && !(context.rng->Uniform() < share)) return value;
    const SampledSpectrum rest =
        plan.rest == PathMethod::LongPathWalk && LongPathWalkApplies(stack, wo, wi)
            ? EstimateLongPaths(stack, wo, wi, context, maxVertices, path.numEvents + 2)
            : ConnectionWalk<WalkPolicy>(stack, context, maxVertices, {path.numEvents}).Estimate(wo, wi);
    return value + rest / share;
}
SampledSpectrum PairsAndRest(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                             int maxVertices) {
    SampledSpectrum value(0);
    const int known =
        AddPairs(stack, wo, wi, context, 2, std::min(maxVertices, PairVerticesFor(stack, wo, wi)), &value);
    return value + EvaluateOthers(stack, wo, wi, context, maxVertices, {known});
}

}  // namespace

SampledSpectrum EstimateByPlan(const QueryPlan& plan, const Stack& stack, Vec3 wo, Vec3 wi,
                               const BxDFContext& context, int maxVertices) {
    switch (plan.shortest) {
        case PathMethod::Product:
            return ProductAndRest(plan, stack, wo, wi, context, maxVertices);
        case PathMethod::PairProduct:
            return PairsAndRest(stack, wo, wi, context, maxVertices);
        case PathMethod::LongPathWalk:
            if (LongPathWalkApplies(stack, wo, wi))
                return EstimateLongPaths(stack, wo, wi, context, maxVertices, 3);
            break;
        case PathMethod::Connection:
            break;
    }
    return EstimateByConnections(stack, wo, wi, context, maxVertices);
}

}  // namespace lacquer::layered
