// Phase function "vmf": that of von Mises and Fisher.
//
//   "float kappa"  1  concentration, >= 0; a texture in slabs
#include "pbrt/phases/vmf.h"

#include "pbrt/phases/angular.h"

namespace lacquer {

VonMisesFisherPhase::VonMisesFisherPhase(float kappa)
    : kappa_(kappa > 0 ? std::min(kappa, kMaxKappa) : 0.f),
      tail_(std::expm1(-2 * kappa_)),
      peak_(tail_ < 0 ? -Inv2Pi * kappa_ / tail_ : Inv4Pi) {}

PhaseValue VonMisesFisherPhase::Evaluate(Vec3 wo, Vec3 wi) const {
    // Nothing is below exp(-80); denormal numbers would only be slow.
    return SymmetricPhase(peak_ * std::exp(-std::min(kappa_ * OneMinusCos(-wo, wi), 80.f)));
}

PhaseSample VonMisesFisherPhase::Sample(Vec3 wo, Rng& rng) const {
    // [Jakob 2012], with the roles of u and 1 - u exchanged: no digit is lost at either end of kappa.
    const Point2 u = rng.Uniform2D();
    const float oneMinusCos = tail_ < 0 ? -std::log1p(u.x * tail_) / kappa_ : 2 * u.x;
    return PhaseRecord(*this, wo, AroundAxis(-wo, std::min(oneMinusCos, 2.f), u.y));
}

namespace {

std::unique_ptr<PhaseModel> Create(const PhaseArgs& args) {
    return std::make_unique<AngularPhaseModel<VonMisesFisherPhase>>(
        ReadPhaseNumber(args, "kappa", 1, 0, Infinity));
}

constexpr std::string_view kParameters[] = {"kappa"};
constexpr PhasePlugin kPlugin{Create, kParameters};

}  // namespace

LACQUER_REGISTER(PhaseKind, "vmf", &kPlugin);

}  // namespace lacquer
