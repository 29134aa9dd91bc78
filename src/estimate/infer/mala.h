// The Metropolis-adjusted Langevin algorithm: steps along the gradient, with noise, accepted or not.
#pragma once

#include "estimate/infer/chain.h"

namespace lacquer::estimate {

/// What a Langevin step found.
struct LangevinStep {
    double acceptProbability = 0;
    bool isAccepted = false;
};
/// y' = y + step^2 / 2 M grad + step M^(1/2) xi, with Metropolis and Hastings' correction; moves `point` if
/// it is accepted.
/// @param metric  diagonal of M; coordinates whose element is zero stay
LangevinStep TakeLangevinStep(const Target& target, double step, const Vector& metric, Random& random,
                              ChainPoint* point);

/// MALA with a diagonal metric. In warm-up the step follows Robbins and Monro to an acceptance of 0.574,
/// which is the best in many dimensions [Roberts and Rosenthal 1998], and the metric the variances of windows
/// that end at a quarter, a half and three quarters of it. Then both are frozen.
class Mala final : public Sampler {
  public:
    using Sampler::Sampler;
    static constexpr double kTargetAcceptance = 0.574;
    /// Changes the first step, which warm-up adapts.
    void SetFirstStep(double step) { firstStep_ = step; }
    ChainState Start(const Target& target, const Vector& y) const override;
    Draw Advance(const Target& target, uint64_t chain, ChainState* state) const override;

  private:
    double firstStep_ = 0.1;
};

/// The preconditioned rule that was published with procedural materials [Guo et al. 2020], as its program has
/// it: the metric comes from a running mean of squared gradients with the constant 0.999 and never stops
/// adapting, and the step grows with the fourth root of the number of accepted steps. It does not keep its
/// target: good for warm-up and as a negative control.
class PublishedMala final : public Sampler {
  public:
    /// What its proposals' variances are multiplied by, for each coordinate.
    static Vector MetricOf(const ChainState& state, const Vector& gradientSquares);
    /// @param delta  variance of a step before preconditioning, 0.005 in the publication
    PublishedMala(uint64_t seed, double delta) : Sampler(seed, 0), delta_(delta) {}
    ChainState Start(const Target& target, const Vector& y) const override;
    Draw Advance(const Target& target, uint64_t chain, ChainState* state) const override;

  private:
    double delta_;
};

/// The published rule as warm-up, and MALA after it with the metric and the step that it came to, both
/// frozen.
class MalaAfterPublished final : public Sampler {
  public:
    MalaAfterPublished(uint64_t seed, uint64_t warmup, double delta)
        : Sampler(seed, warmup), published_(seed, delta), mala_(seed, 0), delta_(delta) {}
    ChainState Start(const Target& target, const Vector& y) const override {
        return published_.Start(target, y);
    }
    Draw Advance(const Target& target, uint64_t chain, ChainState* state) const override;

  private:
    PublishedMala published_;
    Mala mala_;
    double delta_;
};

/// True if `step` of `warmup` is the last one of the window that ends at this fraction of it.
inline bool IsWindowEnd(uint64_t step, uint64_t warmup, uint64_t numerator, uint64_t denominator) {
    return (step + 1) * denominator / warmup == numerator && step * denominator / warmup < numerator;
}

}  // namespace lacquer::estimate
