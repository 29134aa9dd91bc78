// Hamiltonian Monte Carlo.
#pragma once

#include "estimate/infer/chain.h"

namespace lacquer::estimate {

/// HMC with a diagonal metric and trajectories of random length [Hoffman and Gelman 2014]. In warm-up the
/// step follows dual averaging to an acceptance of 0.8, and the metric the variances of windows that end at
/// one and two thirds of it. Then both are frozen. A dense metric is a WhitenedTarget.
class Hmc final : public Sampler {
  public:
    struct Options {
        int maxLeapfrog = 8;  ///< trajectories have 1 to this many steps, all equally often
        double firstStep = 0.1;
        double targetAcceptance = 0.8;
    };
    Hmc(uint64_t seed, uint64_t warmup, const Options& options) : Sampler(seed, warmup), options_(options) {}
    /// Trajectories whose energy grows by more have left the typical set: they count as divergent.
    static constexpr double kDivergence = 1000;
    ChainState Start(const Target& target, const Vector& y) const override;
    Draw Advance(const Target& target, uint64_t chain, ChainState* state) const override;

  private:
    void Adapt(double acceptProbability, ChainState* state) const;
    Options options_;
};

}  // namespace lacquer::estimate
