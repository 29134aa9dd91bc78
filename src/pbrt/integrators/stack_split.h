// Parts of what a stack scatters between two directions, for the passes of layered materials.
#pragma once

#include "pbrt/film/pass_recorder.h"
#include "pbrt/integrators/traced_path.h"

namespace lacquer {

inline LayeredParts Times(LayeredParts parts, SampledSpectrum factor) {
    for (SampledSpectrum& part : parts) part *= factor;
    return parts;
}

/// Estimates the parts by cutting paths within the stack short: those of one vertex are exact, those of at
/// most three a second estimate by the same estimator, and the rest is what the value has beyond them. So the
/// parts add up to the value, each is right in the mean, and the rest may be negative where the estimator
/// draws other walks for shorter paths.
class StackSplit {
  public:
    /// @param rng, dimensions  numbers of the estimate: those that the value itself takes, so that the parts
    ///                         are parts of this very value where the estimator draws the same walks
    explicit StackSplit(const Rng& rng, const BxDFDimensions& dimensions = {})
        : rng_(rng), dimensions_(dimensions) {}

    /// @param f  value of the BxDF for light from `wi`
    LayeredParts Of(const Bsdf& bsdf, Vec3 wi, SampledSpectrum f) const {
        const SampledSpectrum surface = UpTo(1, bsdf, wi), shorter = UpTo(3, bsdf, wi);
        return {surface, shorter - surface, f - shorter};
    }

  private:
    SampledSpectrum UpTo(int maxVertices, const Bsdf& bsdf, Vec3 wi) const {
        Rng rng = rng_;
        BxDFDimensions dimensions = dimensions_;
        return bsdf
            .Evaluate(wi,
                      {.rng = &rng, .needsPdf = false, .maxVertices = maxVertices, .dimensions = &dimensions})
            .f;
    }

    Rng rng_;
    BxDFDimensions dimensions_;
};

/// Shares of the parts in a draw from a stack. @param rng  a copy: others draw on
inline LayeredParts SharesOf(const BxDFSample& sample, const SurfaceInteraction& si, const Bsdf& bsdf,
                             Rng rng) {
    LayeredParts shares{};
    if (sample.numVertices > 0) {
        shares[size_t(LayeredPartOf(sample.numVertices))] = SampledSpectrum(1);
        return shares;
    }
    // The weight is that of paths of all lengths.
    const SampledSpectrum f = sample.weight * (sample.pdf / AbsDot(sample.wi, si.shading.n));
    return Times(StackSplit(Rng(rng.NextBits())).Of(bsdf, sample.wi, f), SafeDivide(SampledSpectrum(1), f));
}

/// Puts a thread's random numbers and counters of models back, so that what is computed for passes alone
/// changes nothing else.
class StateKeeper {
  public:
    explicit StateKeeper(ThreadState* state)
        : state_(state), rng_(state->rng), dimensions_(state->dimensions), bxdf_(state->bxdf) {}
    ~StateKeeper() {
        state_->rng = rng_;
        state_->dimensions = dimensions_;
        state_->bxdf = bxdf_;
    }
    StateKeeper(const StateKeeper&) = delete;
    StateKeeper& operator=(const StateKeeper&) = delete;

  private:
    ThreadState* state_;
    Rng rng_;
    BxDFDimensions dimensions_;
    BxDFCounters bxdf_;
};

}  // namespace lacquer
