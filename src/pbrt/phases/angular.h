// What phase functions that depend on the scattering angle only have in common. All are symmetric, exact to
// sample (weight 1), and cheap to make at each hit.
#pragma once

#include "pbrt/core/sampling.h"
#include "pbrt/phases/angular_lobe.h"
#include "pbrt/phases/phase_params.h"

namespace lacquer {

/// Makes a phase function of one number.
template <class Phase>
class AngularPhaseModel final : public PhaseModel {
  public:
    explicit AngularPhaseModel(PhaseNumber number) : number_(number) {}
    const PhaseFunction* Make(const PhaseContext& context, Arena& arena) const override {
        return arena.New<Phase>(number_.At(context));
    }
    bool IsConstant() const override { return number_.Constant().has_value(); }

  private:
    PhaseNumber number_;
};

}  // namespace lacquer
