// Chains that start from what is known: a sample of their target gives the metric and the starts.
#pragma once

#include <memory>
#include <vector>

#include "estimate/infer/hmc.h"

namespace lacquer::estimate {

/// A sampler in coordinates in which a sample of the target (walks on an emulator, say) has unit covariance:
/// a dense metric that leaves warm-up little to do. Draws are given in the target's own coordinates.
class WhitenedSampler {
  public:
    /// @param target  outlives the object
    /// @param sample  a column for each draw, more of them than rows
    WhitenedSampler(const Target& target, const Matrix& sample, std::unique_ptr<const Sampler> sampler);
    /// States of chains that start at draws of the sample, evenly spaced; in the whitened coordinates, as all
    /// states are.
    std::vector<ChainState> Start(size_t numChains) const;
    /// As RunChains(): goes on until each chain has made `numSteps` steps in all, warm-up included.
    std::vector<std::vector<Draw>> Run(uint64_t numSteps, std::vector<ChainState>* states,
                                       Observer* observer = nullptr) const;

  private:
    Matrix sample_, transform_;
    Vector center_;
    WhitenedTarget target_;
    std::unique_ptr<const Sampler> sampler_;
};

/// The same with HMC.
class WhitenedHmc final : public WhitenedSampler {
  public:
    WhitenedHmc(const Target& target, const Matrix& sample, uint64_t seed, uint64_t warmup)
        : WhitenedSampler(target, sample, std::make_unique<Hmc>(seed, warmup, Hmc::Options())) {}
};

}  // namespace lacquer::estimate
