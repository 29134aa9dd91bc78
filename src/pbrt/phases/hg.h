// Phase function "hg": that of Henyey and Greenstein.
#pragma once

#include "pbrt/base/phase_function.h"

namespace lacquer {

/// p = (1 - g^2) / (4 pi (1 + g^2 - 2 g cos)^1.5), cos = 1 straight on [Henyey and Greenstein 1941]. Written
/// with 1 - cos, so that narrow lobes keep their digits.
class HenyeyGreensteinPhase final : public PhaseFunction {
  public:
    /// Narrower lobes are narrower than float directions can say.
    static constexpr float kMaxG = 0.9999f;

    /// @param g  mean cosine, positive forward; clamped to [-kMaxG, kMaxG], NaN becomes 0
    explicit HenyeyGreensteinPhase(float g);

    PhaseValue Evaluate(Vec3 wo, Vec3 wi) const override;
    PhaseSample Sample(Vec3 wo, Rng& rng) const override;

  private:
    Vec3 Axis(Vec3 wo) const { return isForward_ ? -wo : wo; }

    float absG_;
    bool isForward_;
};

/// Makes it with the mean cosine `g` (not null).
std::unique_ptr<PhaseModel> MakeHenyeyGreensteinPhaseModel(const FloatTexture* g);

}  // namespace lacquer
