// What the product estimators share: they know the shortest paths well, and leave all others to
// ConnectionWalk.
#pragma once

#include "layered/connection_walk.h"
#include "layered/estimator.h"
#include "layered/paths/interface_sequences.h"
#include "layered/paths/products/pair_walk.h"

namespace lacquer::layered {

/// The number of vertices up to which unscattered paths are worth pair products: one pass through the stack,
/// or down to its base and back. Measured at equal time, see docs/product-sampling.md. The walks of longer
/// stacks are left to others.
inline int PairVerticesFor(const Stack& stack, Vec3 wo, Vec3 wi) {
    constexpr int kMaxVertices = 7;
    return std::min(SameHemisphere(wo, wi) ? 2 * stack.Last() + 1 : stack.Last() + 1, kMaxVertices);
}

/// How often to estimate the paths of three vertices, which turn at the second interface: seldom where that
/// reflects much less than what lies below it.
inline float ShortestPathProbability(const Stack& stack, Vec3 wo, Vec3 wi, int maxVertices) {
    if (!SameHemisphere(wo, wi) || stack.Last() < 2 || maxVertices < 5) return 1;
    const int outer = stack.OuterTowards(wi), inner = wi.z > 0 ? 1 : outer - 1;
    // Pairs for these paths alone look for a lobe that pairs for longer ones do without.
    const auto facets = stack.interfaces[size_t(inner)].IsotropicFacets();
    if (!facets || !HasLobeOf(*facets, false)) return 1;
    return SequenceProbability(SmoothThroughput(stack, std::array{outer, inner, outer}),
                               LargestSmoothThroughput(stack, wo, wi, maxVertices));
}

/// Adds the unscattered paths of `minVertices` to `maxVertices` vertices, or to somewhat fewer, by pair
/// products. Gives the number of vertices up to which it did, minVertices - 1 if pair products are
/// impossible.
template <class Policy = PairPolicy>
int AddPairs(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context, int minVertices,
             int maxVertices, SampledSpectrum* value) {
    constexpr int kShortest = 3;
    // Below an interface without lobes the paths above it may still do: those of less than one pass.
    for (int known = maxVertices; known >= minVertices; known = std::min(known - 2, 2 * stack.Last() + 1)) {
        const float share = minVertices <= kShortest ? ShortestPathProbability(stack, wo, wi, known) : 1;
        PairWalk<Policy> walk(stack, context, known, share < 1 ? kShortest + 1 : minVertices);
        if (!walk.Set(wo, wi)) continue;
        *value += walk.Estimate();
        if (share < 1 && context.rng->Uniform() < share) {
            PairWalk<Policy> shortest(stack, context, kShortest, minVertices);
            if (shortest.Set(wo, wi)) *value += shortest.Estimate() / share;
        }
        return known;
    }
    return minVertices - 1;
}

/// How many estimates of all other paths to take for each one of the known ones: the quotient of their noise
/// over the known paths' noise, times the root of the quotient of costs. Any positive number is right; those
/// here were measured. Light that passes straight through seldom comes back, unless the boundaries are rough
/// and the index is large; light that a smooth base reflects spreads little at the boundary and comes back
/// weakly.
inline float NumOtherEstimates(const Stack& stack, Vec3 wo, Vec3 wi, KnownPaths known) {
    // More than kMax would pay for noise of the known paths that is nowhere seen beside other noise.
    constexpr float kOften = 0.8f, kMax = 2;
    // More interfaces, more noise in the known paths.
    const float smallest = stack.Last() > 1 ? 0.15f : 0.25f;
    const bool isReflection = SameHemisphere(wo, wi);
    if (std::max(known.vertices, known.directVertices) < 2 || stack.Scatters()) return 1;
    // Where the known paths do not reach the base, the others may carry nearly all light.
    if (isReflection && std::max(known.vertices, known.directVertices) < 2 * stack.Last() + 1) return 1;
    float alphaTop = 1, alphaBase = 1, trapping = 0;
    const int outer = stack.OuterTowards(wi), base = stack.Last() - outer;
    for (int i = 0; i <= stack.Last(); ++i) {
        const auto facets = stack.interfaces[size_t(i)].IsotropicFacets();
        if (!facets) return 1;
        if (i == outer) alphaTop = facets->alphaX;
        if (i == base) alphaBase = facets->alphaX;
        if (facets->eta == 0) continue;
        const float contrast = Sqr(std::max(facets->eta, 1 / facets->eta) - 1);
        trapping = std::max(trapping, isReflection ? contrast : facets->alphaX * contrast);
    }
    const float share =
        isReflection ? 12 * Sqr(alphaBase) / alphaTop * std::max(1.f, 4 * trapping) : trapping;
    return share > kOften ? std::min(std::max(1.f, std::round(share)), kMax) : std::max(share, smallest);
}

/// An estimate of all paths but the known ones.
inline SampledSpectrum EvaluateOthers(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                                      int maxVertices, KnownPaths known) {
    if (maxVertices <= known.vertices && !stack.Scatters()) return SampledSpectrum(0);
    const float share = NumOtherEstimates(stack, wo, wi, known);
    if (share < 1 && !(context.rng->Uniform() < share)) return SampledSpectrum(0);
    SampledSpectrum sum(0);
    for (int i = 0; i < std::max(1, int(share)); ++i)
        sum += ConnectionWalk<WalkPolicy>(stack, context, maxVertices, known).Estimate(wo, wi);
    return sum / share;
}

}  // namespace lacquer::layered
