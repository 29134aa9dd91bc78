// Who estimates which part of the light between two directions: decided anew for each query, since the share
// of the shortest path goes from all to nothing with the directions.
#pragma once

#include "layered/estimator.h"

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

/// The plan with the least noise for its time, by rules that fit what was measured over random stacks and
/// directions: each is a region where a method was seen to win. Outside of all of them it is connections
/// alone. Depends on nothing that is drawn.
QueryPlan PlanQuery(const Stack& stack, Vec3 wo, Vec3 wi, int maxVertices);

/// One unbiased estimate of all light on paths of 2 to maxVertices vertices [1/sr, without the cosine] by a
/// plan. Any plan will do: where its method is impossible, connections take over.
SampledSpectrum EstimateByPlan(const QueryPlan& plan, const Stack& stack, Vec3 wo, Vec3 wi,
                               const BxDFContext& context, int maxVertices);

}  // namespace lacquer::layered
