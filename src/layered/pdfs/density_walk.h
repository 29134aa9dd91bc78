// The density with which a walk through a stack leaves it, estimated by connections.
#pragma once

#include "layered/connection_walk.h"
#include "layered/estimator.h"

namespace lacquer::layered {

struct DensityPolicy : WalkPolicy {
    using ValueType = float;
};
/// Of light that no slab scatters.
struct UnscatteredDensityPolicy : DensityPolicy {
    static constexpr bool kOnlyUnscattered = true;
};

/// An unbiased estimate of the density of wi given wo [1/sr], of paths of at most `maxVertices` vertices
/// [Guo et al. 2018, eq. 24-27]: the exact one of the outer interface, and a bidirectional estimate of the
/// others. LayeredBxDF::Sample() ends long walks by roulette; that factor is left out.
template <class Policy>
float DensityOfExit(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context, int maxVertices) {
    BxDFContext analog = context;
    analog.sides = Lobes::BothSides;
    float pdf = 0;
    const int outer = stack.OuterTowards(wo);
    if (SameHemisphere(wo, wi) || stack.Last() == 0)
        pdf += stack.interfaces[size_t(outer)].Evaluate(wo, wi, analog).pdf;
    return pdf + ConnectionWalk<Policy>(stack, context, maxVertices).Estimate(wo, wi);
}

}  // namespace lacquer::layered
