// Phase function "isotropic": the same in all directions. No parameters.
#include "pbrt/phases/isotropic.h"

#include "pbrt/phases/angular.h"

namespace lacquer {

PhaseValue IsotropicPhase::Evaluate(Vec3 /*wo*/, Vec3 /*wi*/) const { return SymmetricPhase(Inv4Pi); }

PhaseSample IsotropicPhase::Sample(Vec3 wo, Rng& rng) const {
    return PhaseRecord(*this, wo, SampleUniformSphere(rng.Uniform2D()));
}

namespace {

class IsotropicModel final : public PhaseModel {
  public:
    const PhaseFunction* Make(const PhaseContext&, Arena& arena) const override {
        return arena.New<IsotropicPhase>();
    }
};

std::unique_ptr<PhaseModel> Create(const PhaseArgs&) { return MakeIsotropicPhaseModel(); }

constexpr PhasePlugin kPlugin{Create, {}};

}  // namespace

std::unique_ptr<PhaseModel> MakeIsotropicPhaseModel() { return std::make_unique<IsotropicModel>(); }

LACQUER_REGISTER(PhaseKind, "isotropic", &kPlugin);

}  // namespace lacquer
