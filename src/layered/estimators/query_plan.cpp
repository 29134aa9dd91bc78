#include "layered/estimators/query_plan.h"

#include "layered/estimators/light_forecast.h"
#include "layered/estimators/short_paths.h"
#include "layered/paths/half_vectors/shortest_path.h"
#include "layered/paths/long_paths/long_path.h"
#include "layered/slopes/facet_slopes.h"
#include "pbrt/scattering/fresnel.h"
#include "pbrt/scattering/microfacet.h"

namespace lacquer::layered {
namespace {

constexpr QueryPlan kLongPathsOnly = {PathMethod::LongPathWalk, PathMethod::LongPathWalk, 1};
constexpr QueryPlan kProductAndLongPaths = {PathMethod::Product, PathMethod::LongPathWalk, 1};
constexpr QueryPlan kConnections = {};
constexpr float kSeldom = 0.15f;     ///< smallest probability of the rest
constexpr float kMaxGrazing = 0.3f;  ///< of products of other distributions than Beckmann's
/// Under one coat: of long paths and half vectors for Beckmann's distribution, of mixtures for others.
constexpr float kMaxExponentOfWalks = 6, kMaxExponentOfHalfVectors = 4.5f, kMaxExponentOfMixtures = 2;
constexpr float kRoughBase = 0.4f;  ///< from where walks of long paths make all light

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
    if (alphaBase >= kRoughBase && f.exponent < kMaxExponentOfWalks) return kLongPathsOnly;
    if (!(f.grazing < 50) || !(f.exponent < kMaxExponentOfHalfVectors)) return kConnections;
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
/// Of both outer directions, the flatter one counting most.
float FlatCosine(Vec3 wo, Vec3 wi) {
    const auto [flat, steep] = std::minmax(wo.z, wi.z);
    return flat * std::sqrt(std::sqrt(steep));
}
/// Tails that fall by a power of the slope have facets that refract light at grazing views to the horizon of
/// the base. Where both ends may, the base joins such directions by a lobe that is brighter by the product of
/// their cosines, and a walk that draws them from the coat only meets it far too seldom. Smoother coats have
/// less of such facets; a rough coat over a rougher base finds nothing brighter at the horizon.
bool IsTooFlatForLongPaths(const MicrofacetSurface& coat, const MicrofacetSurface& base, float flatCosine) {
    constexpr float kRoughCoat = 0.2f, kRougherBase = 0.5f, kHorizon = 0.02f, kFlattest = 0.2f;
    if (coat.alphaX >= kRoughCoat && base.alphaX >= kRougherBase) return flatCosine < kHorizon;
    return flatCosine < std::min(0.025f + 0.6f * coat.alphaX, kFlattest);
}
/// The same for draws from mixtures. A base much smoother than the coat has a lobe too narrow for it.
bool IsTooFlatForMixtures(const MicrofacetSurface& coat, const MicrofacetSurface& base, float flatCosine) {
    return base.alphaX > 0.5f * coat.alphaX && flatCosine < 0.02f + 1.2f * coat.alphaX;
}
QueryPlan PlanOtherCoat(const MicrofacetSurface& coat, const MicrofacetSurface& base, const LightForecast& f,
                        float flatCosine) {
    // Where lobes are so narrow, connections find the longer paths with less noise than the walk for them.
    constexpr float kSmoothBase = 0.15f, kMinQuotient = 0.7f, kSmallQuotient = 0.25f;
    const float alphaCoat = coat.alphaX, alphaBase = base.alphaX;
    if (f.exponent < MaxExponentOfLongPaths(alphaCoat, alphaBase))
        return IsTooFlatForLongPaths(coat, base, flatCosine) ? kConnections : kLongPathsOnly;
    if (!(f.exponent < kMaxExponentOfMixtures) || !(f.grazing < kMaxGrazing) ||
        IsTooFlatForMixtures(coat, base, flatCosine))
        return kConnections;
    // Connections through a coat so much smoother have little noise already.
    if (alphaBase <= kSmoothBase && alphaCoat < kSmallQuotient * alphaBase) return kConnections;
    if (alphaBase <= kSmoothBase ? alphaCoat <= kMinQuotient * alphaBase : alphaCoat <= 1.5f * alphaBase)
        return kProductAndLongPaths;
    return alphaCoat < 0.6f && f.grazing < 0.2f ? PlanProduct(f, coat, base, 1.5f, 0.2f) : kConnections;
}
/// True if no plan of PlanOtherCoat() wants these directions, whatever the forecast says.
bool NeedsNoForecast(const MicrofacetSurface& coat, const MicrofacetSurface& base, Vec3 wo, Vec3 wi,
                     float flatCosine) {
    if (MaxExponentOfLongPaths(coat.alphaX, base.alphaX) > 0 &&
        !IsTooFlatForLongPaths(coat, base, flatCosine))
        return false;
    const float z2 = Sqr(std::min(wo.z, wi.z));
    return IsTooFlatForMixtures(coat, base, flatCosine) ||
           coat.alphaX >= std::max(0.6f, 1.5f * base.alphaX) ||
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
    if (!ForecastLight(stack, wo, wi, maxExponent, &forecast) || forecast.reflectsTotally)
        return kConnections;
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
    const float flatCosine = isBeckmann ? 1 : FlatCosine(wo, wi);
    if (!isBeckmann && NeedsNoForecast(*coat, *base, wo, wi, flatCosine)) return kConnections;
    LightForecast forecast;
    const float maxExponent =
        !isBeckmann ? std::max(MaxExponentOfLongPaths(coat->alphaX, base->alphaX), kMaxExponentOfMixtures)
        : base->alphaX >= kRoughBase ? kMaxExponentOfWalks
                                     : kMaxExponentOfHalfVectors;
    if (!ForecastLight(stack, wo, wi, maxExponent, &forecast) || forecast.reflectsTotally)
        return kConnections;
    return isBeckmann ? PlanBeckmannCoat(*coat, *base, forecast)
                      : PlanOtherCoat(*coat, *base, forecast, flatCosine);
}

/// The boundary of a stack that light passes, where it goes along w.
const MicrofacetSurface& OuterFacets(const Stack& stack, Vec3 w) {
    return *FacetsOf(stack.interfaces[size_t(stack.OuterTowards(w))]);
}
/// As LightForecast has it.
float GrazingOf(const MicrofacetSurface& facets, Vec3 w) {
    return 0.5f * Sqr(std::max(facets.alphaX, facets.alphaY)) * (1 - w.z * w.z) / std::max(w.z * w.z, 1e-6f);
}
/// Of the smooth boundary.
float ReflectanceOf(const MicrofacetSurface& facets, Vec3 w) {
    return FresnelDielectric(std::abs(w.z), w.z > 0 ? facets.eta : 1 / facets.eta);
}
/// How often to make all but the shortest path. These reflect inside at the boundaries, which do so as much
/// as outside: hardly at steep views, and then once in a while will do; at flat ones they carry much of the
/// light, and over a rough boundary nearly all noise.
float RestOfPasses(const Stack& stack, Vec3 wo, Vec3 wi, float reflectance, float roughest, bool isBeckmann,
                   float exponent) {
    const bool isPane = stack.Last() == 1;
    const float perReflectance = !isPane      ? 1
                                 : isBeckmann ? 2.2f + 8 * roughest
                                              : 2.2f,
                largest = isPane ? 1 : 0.65f;
    // Off the middle of the lobe the other paths carry more.
    const float least =
        NumOtherEstimates(stack, wo, wi, {stack.Last() + 1}) * std::exp(std::max(0.f, 1.2f * (exponent - 1)));
    return std::max(least, std::min(perReflectance * reflectance, largest));
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
    const float maxExponent = isIsotropic ? (isBeckmann ? 4.5f : 2.5f) : isBeckmann ? 3 : 2.1f;
    const float maxGrazing = !isBeckmann ? 0.2f : isIsotropic ? Infinity : 2;
    const MicrofacetSurface &light = OuterFacets(stack, wi), &camera = OuterFacets(stack, wo);
    const float grazingOfEnds = std::max(GrazingOf(light, wi), GrazingOf(camera, wo));
    if (grazingOfEnds > maxGrazing) return kConnections;
    LightForecast forecast;
    if (!ForecastLight(stack, wo, wi, maxExponent, &forecast) || forecast.reflectsTotally)
        return kConnections;
    const float grazing = std::max(forecast.grazing, grazingOfEnds);
    if (forecast.exponent > maxExponent || grazing > maxGrazing) return kConnections;
    // A flat view of facets that turn light to a steep one takes those far out in their lobe.
    constexpr float kOneFlatEnd = 3, kFlatter2 = 25;
    const float wi2 = wi.z * wi.z, wo2 = wo.z * wo.z;
    if (grazing > kOneFlatEnd && std::max(wi2, wo2) > kFlatter2 * std::min(wi2, wo2)) return kConnections;
    // Half vectors do not know facets that turn light so far, as those between similar indices have to.
    constexpr float kMaxSlope2 = 2;
    if (stack.Last() == 2 && forecast.squaredSlope > kMaxSlope2) return kConnections;
    // Nearly all light is reflected more often.
    constexpr float kMaxReflectance = 0.9f, kSmooth = 0.07f;
    const float reflectance = std::max(ReflectanceOf(light, wi), ReflectanceOf(camera, wo));
    if (stack.Last() == 1 && smoothest < kSmooth && reflectance > kMaxReflectance) return kConnections;
    return ProductAndConnections(
        RestOfPasses(stack, wo, wi, reflectance, roughest, isBeckmann, forecast.exponent));
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
