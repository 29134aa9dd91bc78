// HMC that starts from what is known: a sample of its target gives the metric and the starts.
#pragma once

#include <vector>

#include "estimate/infer/hmc.h"

namespace lacquer::estimate {

/// HMC in coordinates in which a sample of the target (walks on an emulator, say) has unit covariance: a
/// dense metric that leaves warm-up little to do. Draws are given in the target's own coordinates.
class WhitenedHmc {
  public:
    /// @param target  outlives the object
    /// @param sample  a column for each draw, more of them than rows
    WhitenedHmc(const Target& target, const Matrix& sample, uint64_t seed, uint64_t warmup);
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
    Hmc hmc_;
};

}  // namespace lacquer::estimate
