// Chains over continuous and discrete parameters.
#pragma once

#include <vector>

#include "estimate/infer/chain.h"

namespace lacquer::estimate {

/// Continuous parameters y together with a kind: one combination of the values of all discrete parameters.
/// Densities of different kinds are relative to the same constant.
struct MixedTarget {
    std::vector<const Target*> kinds;  ///< all of one size; they outlive the object
    /// For each coordinate whether gradients are of use; the others are moved one at a time, without.
    std::vector<bool> isSmooth;
};

/// Alternates between kinds of moves [Guo et al. 2020, algorithm 1]: mostly a Langevin step of the smooth
/// coordinates, else one of what is not smooth, chosen uniformly: a new kind, uniform among the others, or a
/// random walk of one coordinate. All are accepted by Metropolis and Hastings' rule. Steps are adapted in
/// warm-up as Mala does (random walks to an acceptance of 0.44), then frozen.
class MixedChain {
  public:
    /// @param seed, warmup  as of a Sampler
    MixedChain(uint64_t seed, uint64_t warmup) : seed_(seed), warmup_(warmup) {}
    /// Part of the steps that are Langevin steps.
    static constexpr double kSmoothPart = 0.8;
    ChainState Start(const MixedTarget& target, const Vector& y, uint64_t kind) const;
    Draw Advance(const MixedTarget& target, uint64_t chain, ChainState* state) const;
    /// As RunChains().
    std::vector<std::vector<Draw>> Run(const MixedTarget& target, uint64_t numSteps,
                                       std::vector<ChainState>* states, Observer* observer = nullptr) const;

  private:
    /// The moves return the probability of acceptance.
    double MoveSmooth(const MixedTarget& target, Random& random, ChainState* state) const;
    double MoveKind(const MixedTarget& target, Random& random, ChainState* state) const;
    double MoveCoordinate(const MixedTarget& target, Eigen::Index coordinate, Random& random,
                          ChainState* state) const;
    void AdaptMetric(const MixedTarget& target, ChainState* state) const;

    uint64_t seed_, warmup_;
};

}  // namespace lacquer::estimate
