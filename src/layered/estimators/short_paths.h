// What the product estimators share: they know the shortest paths well, and leave all others to
// ConnectionWalk.
#pragma once

#include "layered/chains/pair_walk.h"
#include "layered/connection_walk.h"
#include "layered/estimator.h"

namespace lacquer {

/// The number of vertices up to which unscattered paths are worth pair products: one pass through the stack,
/// or down to its base and back. Measured at equal time, see docs/product-sampling.md. The walks of longer
/// stacks are left to others.
inline int PairVerticesFor(const Stack& stack, Vec3 wo, Vec3 wi) {
    if (!SameHemisphere(wo, wi)) return stack.Last() + 1;
    return std::min(2 * stack.Last() + 1, PairWalk<>::kMaxVertices);
}

/// Adds the unscattered paths of `minVertices` to `maxVertices` vertices, or to somewhat fewer, by pair
/// products. Gives the number of vertices up to which it did, minVertices - 1 if pair products are
/// impossible.
inline int AddPairs(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context, int minVertices,
                    int maxVertices, SampledSpectrum* value) {
    // Below an interface without lobes the paths above it may still do.
    for (int known = maxVertices; known >= minVertices; known -= 2) {
        if (known > PairWalk<>::kMaxVertices) continue;
        PairWalk<> walk(stack, context, known, minVertices);
        if (!walk.Set(wo, wi)) continue;
        *value += walk.Estimate();
        return known;
    }
    return minVertices - 1;
}

/// How often to estimate all other paths for each estimate of the known ones, at most 1: the quotient of
/// their noise over the known paths' noise, times the root of the quotient of costs. Any positive number is
/// right; those here were measured at two interfaces. Light that passes straight through seldom comes back,
/// unless the boundaries are rough and the index is large; light that a smooth base reflects spreads little
/// at the boundary and comes back weakly.
inline float ShareOfOthers(const Stack& stack, Vec3 wo, Vec3 wi, int known) {
    constexpr float kOften = 0.8f;
    // More interfaces, more noise in the known paths.
    const float smallest = stack.Last() > 1 ? 0.15f : 0.25f;
    const bool isReflection = SameHemisphere(wo, wi);
    if (known < 2 || stack.Scatters() || (isReflection && stack.Last() > 1)) return 1;
    float alphaTop = 1, alphaBase = 1, trapping = 0;
    const int outer = stack.OuterTowards(wi);
    for (int i = 0; i <= stack.Last(); ++i) {
        const auto facets = stack.interfaces[size_t(i)].IsotropicFacets();
        if (!facets) return 1;
        (i == outer ? alphaTop : alphaBase) = facets->alphaX;
        if (facets->eta == 0) continue;
        const float contrast = Sqr(std::max(facets->eta, 1 / facets->eta) - 1);
        trapping = std::max(trapping, isReflection ? contrast : facets->alphaX * contrast);
    }
    const float share =
        isReflection ? 12 * Sqr(alphaBase) / alphaTop * std::max(1.f, 4 * trapping) : trapping;
    return share > kOften ? 1 : std::max(share, smallest);
}

/// An estimate of all paths but the unscattered ones of at most `known` vertices (1: of all).
inline SampledSpectrum EvaluateOthers(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                                      int maxVertices, int known) {
    if (maxVertices <= known && !stack.Scatters()) return SampledSpectrum(0);
    const float share = ShareOfOthers(stack, wo, wi, known);
    if (share < 1 && !(context.rng->Uniform() < share)) return SampledSpectrum(0);
    return ConnectionWalk<WalkPolicy>(stack, context, maxVertices, known).Estimate(wo, wi) / share;
}

}  // namespace lacquer
