// What phase functions that depend on the scattering angle only have in common. All are symmetric, exact to
// sample (weight 1), and cheap to make at each hit.
#pragma once

#include "pbrt/core/sampling.h"
#include "pbrt/phases/phase_params.h"

namespace lacquer {

inline PhaseValue SymmetricPhase(float p) { return {p, p, p}; }

/// The end of all Sample(): value and density come from one place. Asking anew costs a few ns and gives what
/// a later query will give.
inline PhaseSample PhaseRecord(const PhaseFunction& phase, Vec3 wo, Vec3 wi) {
    const PhaseValue value = phase.Evaluate(wo, wi);
    return {wi, 1, value.pdf, value.pdfReverse};
}

/// 1 - cos of the angle between unit vectors, with a small relative error also where it is tiny.
inline float OneMinusCos(Vec3 a, Vec3 b) { return 0.5f * LengthSquared(a - b); }

/// Unit vector at a given angle to the axis, at a random azimuth.
inline Vec3 AroundAxis(Vec3 axis, float oneMinusCos, float u) {
    const float sine = SafeSqrt(oneMinusCos * (2 - oneMinusCos)), phi = 2 * Pi * u;
    Vec3 x, y;
    CoordinateSystem(axis, &x, &y);
    // Long walks must not let the length drift.
    return Normalize(axis - oneMinusCos * axis + sine * (std::cos(phi) * x + std::sin(phi) * y));
}

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
