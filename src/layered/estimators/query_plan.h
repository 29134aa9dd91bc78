// Who estimates which part of the light between two directions: decided anew for each query, since the share
// of the shortest path goes from all to nothing with the directions.
#pragma once

#include "layered/estimator.h"
#include "layered/estimators/light_forecast.h"

namespace lacquer::layered {

/// Ways to estimate a part of the light.
enum class PathMethod {
    Product,       ///< EstimateShortestPath(): of the shortest path only
    LongPathWalk,  ///< EstimateLongPaths()
    PairProduct,   ///< AddPairs() for all paths of one pass, and walks for the others
    Connection,    ///< ConnectionWalk
};

/// A division of the light of all paths of two and more vertices.
struct QueryPlan {
    /// Of the shortest path. Other than Product it goes for all light, and `rest` does not matter.
    PathMethod shortest = PathMethod::Connection;
    PathMethod rest = PathMethod::Connection;
    /// Probability, in (0, 1], with which the rest is estimated; the estimate is divided by it.
    float restProbability = 1;
};

/// True if the smooth boundary would reflect all light from there.
inline bool ReflectsTotally(const Stack& stack, Vec3 w) {
    const MicrofacetSurface* outer = FacetsOf(stack.interfaces[size_t(stack.OuterTowards(w))]);
    if (!outer || outer->eta == 0) return false;
    return 1 - w.z * w.z > Sqr(w.z > 0 ? outer->eta : 1 / outer->eta);
}

/// False where there is nothing to plan but connections, by the kind of stack and by the sides.
inline bool HasPlans(const Stack& stack, Vec3 wo, Vec3 wi) {
    const int last = stack.Last();
    if (last < 1 || last > 2) return false;
    if (SameHemisphere(wo, wi)) {
        // Thinner coats let no light in beyond an angle, and change what they do near it.
        const MicrofacetSurface* coat = FacetsOf(stack.interfaces[0]);
        if (!(wo.z > 0) || !coat || !(coat->eta > 1) || stack.interfaces[size_t(last)].transmits)
            return false;
    } else if (ReflectsTotally(stack, wo) || ReflectsTotally(stack, wi)) {
        return false;
    }
    return !stack.slabs[0].Scatters() && !stack.slabs[size_t(last - 1)].Scatters();
}

/// PlanQuery() where HasPlans().
QueryPlan ChoosePlan(const Stack& stack, Vec3 wo, Vec3 wi, int maxVertices);

/// The plan with the least noise for its time, by rules that fit what was measured over random stacks and
/// directions: each is a region where a method was seen to win. Outside of all of them it is connections
/// alone. Depends on nothing that is drawn. Inline where it has no choice: some of these walks end at once,
/// and a call would be several per cent of their time.
inline QueryPlan PlanQuery(const Stack& stack, Vec3 wo, Vec3 wi, int maxVertices) {
    return HasPlans(stack, wo, wi) ? ChoosePlan(stack, wo, wi, maxVertices) : QueryPlan{};
}

/// One unbiased estimate of all light on paths of 2 to maxVertices vertices [1/sr, without the cosine] by a
/// plan. Any plan will do: where its method is impossible, connections take over.
SampledSpectrum EstimateByPlan(const QueryPlan& plan, const Stack& stack, Vec3 wo, Vec3 wi,
                               const BxDFContext& context, int maxVertices);
/// The same by the plan that has connections only.
SampledSpectrum EstimateByConnections(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                                      int maxVertices);

}  // namespace lacquer::layered
