// Who estimates what under a rough coat: the shortest path (coat, base, coat) and all longer ones.
#pragma once

#include "layered/connection_walk.h"
#include "layered/paths/long_paths/long_path.h"

namespace lacquer::layered {

/// Ways to estimate a part of the light under a coat.
enum class PathMethod {
    Product,       ///< a product estimator of the shortest path, such as half-vector sampling
    LongPathWalk,  ///< EstimateLongPaths()
    Connection,    ///< ConnectionWalk
};

/// A division of the light that goes through a coat and off a base.
struct LongPathPlan {
    PathMethod shortest = PathMethod::Connection, rest = PathMethod::Connection;
    /// Probability, in (0, 1], with which the rest is estimated; the estimate is divided by it.
    float restProbability = 1;
};

/// The plan of least noise in a given time, without a pilot: a rule that fits what was measured over alphas
/// of 0.05 to 0.5, and is at least as good as ConnectionWalk alone on each of those stacks.
/// @param hasProduct  a product estimator of the shortest path exists
LongPathPlan PlanLongPaths(const MicrofacetSurface& coat, const MicrofacetSurface& base, bool hasProduct);

/// One unbiased estimate of all light on paths of 3 to maxVertices vertices [1/sr, without the cosine] by a
/// plan, where LongPathWalkApplies().
/// @param shortest  () -> one estimate of the shortest path by a product estimator; called by plans that want
///                  it only
template <class ShortestEstimate>
SampledSpectrum EstimateByPlan(const LongPathPlan& plan, const Stack& stack, Vec3 wo, Vec3 wi,
                               const BxDFContext& context, int maxVertices,
                               const ShortestEstimate& shortest) {
    if (maxVertices < 3) return SampledSpectrum(0);
    if (plan.shortest == PathMethod::LongPathWalk)
        return EstimateLongPaths(stack, wo, wi, context, maxVertices, 3);
    if (plan.shortest == PathMethod::Connection)
        return ConnectionWalk<WalkPolicy>(stack, context, maxVertices).Estimate(wo, wi);

    const SampledSpectrum value = shortest();
    if (maxVertices < 5 || (plan.restProbability < 1 && !(context.rng->Uniform() < plan.restProbability)))
        return value;
    const SampledSpectrum rest =
        plan.rest == PathMethod::LongPathWalk
            ? EstimateLongPaths(stack, wo, wi, context, maxVertices, 5)
            : ConnectionWalk<WalkPolicy>(stack, context, maxVertices, {3}).Estimate(wo, wi);
    return value + rest / plan.restProbability;
}

}  // namespace lacquer::layered
