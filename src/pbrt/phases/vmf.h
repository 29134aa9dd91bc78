// Phase function "vmf": that of von Mises and Fisher.
#pragma once

#include "pbrt/base/phase_function.h"

namespace lacquer {

/// p = kappa exp(kappa cos) / (4 pi sinh kappa), cos = 1 straight on: the von Mises-Fisher distribution, also
/// called normalised exponential. Mean cosine coth(kappa) - 1/kappa.
class VonMisesFisherPhase final : public PhaseFunction {
  public:
    static constexpr float kMaxKappa = 1e6f;

    /// @param kappa  concentration, 0 isotropic; clamped to [0, kMaxKappa], NaN becomes 0
    explicit VonMisesFisherPhase(float kappa);

    PhaseValue Evaluate(Vec3 wo, Vec3 wi) const override;
    PhaseSample Sample(Vec3 wo, Rng& rng) const override;

  private:
    float kappa_;
    float tail_;  ///< exp(-2 kappa) - 1
    float peak_;  ///< p straight on [1/sr]
};

}  // namespace lacquer
