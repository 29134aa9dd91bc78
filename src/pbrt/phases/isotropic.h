// Phase function "isotropic".
#pragma once

#include "pbrt/base/phase_function.h"

namespace lacquer {

/// The same in all directions.
class IsotropicPhase final : public PhaseFunction {
  public:
    PhaseValue Evaluate(Vec3 wo, Vec3 wi) const override;
    PhaseSample Sample(Vec3 wo, Rng& rng) const override;
};

/// Makes it.
std::unique_ptr<PhaseModel> MakeIsotropicPhaseModel();

}  // namespace lacquer
