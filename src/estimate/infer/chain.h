// Markov chains whose every step is a function of (seed, chain, step) and the state: the same draws for any
// number of threads, and after an interruption.
#pragma once

#include <vector>

#include "estimate/infer/target.h"
#include "estimate/random.h"
#include "pbrt/core/progress.h"

namespace lacquer::estimate {

/// A point with what the target says there.
struct ChainPoint {
    Vector y;
    double logDensity = 0;
    Vector gradient;
};

/// Step size from warm-up: an average that forgets its start [Hoffman and Gelman 2014], or Robbins and
/// Monro's.
struct StepAdaptation {
    double logStep = 0;
    double logStepAverage = 0, error = 0, center = 0;  ///< of dual averaging
    double count = 0;
};

/// Variances of the draws of a window [Welford 1962].
struct WindowVariances {
    double count = 0;
    Vector mean, squares;
    void Add(const Vector& y);
    /// (n variance + 5e-3) / (n + 5) for n draws: steadies short windows.
    Vector Regularized() const;
};

/// All that a chain needs to go on: saved and read again, it continues with the same bits.
struct ChainState {
    uint64_t step = 0;  ///< steps done, warm-up included
    ChainPoint point;
    StepAdaptation adaptation;
    Vector metric;  ///< estimates of the target's variances
    WindowVariances window;
    /// Of the published rule: running means of the gradient and of its square, and accepted steps.
    Vector gradientMean, gradientSquares;
    double accepted = 0;
    /// Of chains with discrete parameters: the combination of their values, and steps of single parameters.
    uint64_t kind = 0;
    Vector logSteps;
};

/// One step of a chain, as it is recorded.
struct Draw {
    Vector y;  ///< the state after the step: of a rejected one, the old state again
    double logDensity = 0;
    uint64_t kind = 0;
    double acceptStat = 0;  ///< probability of acceptance
    double stepSize = 0;
    int numLeapfrog = 0;
    bool isDivergent = false, isAccepted = false;
    double energy = 0;  ///< minus the logarithm of the joint density of state and momentum
};

/// A rule by which chains move. Adapts itself for `warmup` steps and never after, since a chain that goes on
/// adapting need not keep its target [Roberts and Rosenthal 2009].
class Sampler {
  public:
    Sampler(uint64_t seed, uint64_t warmup) : seed_(seed), warmup_(warmup) {}
    virtual ~Sampler() = default;
    uint64_t Warmup() const { return warmup_; }
    /// A chain at its first point, where the density must not be zero.
    virtual ChainState Start(const Target& target, const Vector& y) const;
    /// One step.
    virtual Draw Advance(const Target& target, uint64_t chain, ChainState* state) const = 0;

  protected:
    Random NumbersOf(uint64_t chain, const ChainState& state) const {
        return Random(seed_, chain, state.step);
    }
    bool IsWarmup(const ChainState& state) const { return state.step < warmup_; }

  private:
    uint64_t seed_, warmup_;
};

/// Advances all chains until each has made `numSteps` steps in all, in parallel over chains.
/// @param states  in: where to go on; out: where they ended, before `numSteps` only if the observer has
/// stopped
/// @return        for each chain the draws made now, those of warm-up included
std::vector<std::vector<Draw>> RunChains(const Sampler& sampler, const Target& target, uint64_t numSteps,
                                         std::vector<ChainState>* states, Observer* observer = nullptr);

/// Draws after warm-up of one coordinate: rows are draws, columns are chains.
Matrix CoordinateOf(const std::vector<std::vector<Draw>>& chains, size_t firstDraw, Eigen::Index coordinate);

}  // namespace lacquer::estimate
