// Phase function "hg": that of Henyey and Greenstein.
#pragma once

#include "pbrt/phases/angular_lobe.h"

namespace lacquer {

/// p = (1 - g^2) / (4 pi (1 + g^2 - 2 g cos)^1.5), cos = 1 straight on [Henyey and Greenstein 1941]. Written
/// with 1 - cos, so that narrow lobes keep their digits.
class HenyeyGreensteinPhase final : public PhaseFunction {
  public:
    /// Narrower lobes are narrower than float directions can say.
    static constexpr float kMaxG = 0.9999f;

    /// @param g  mean cosine, positive forward; clamped to [-kMaxG, kMaxG], NaN becomes 0
    explicit HenyeyGreensteinPhase(float g);

    /// Inline, both: slabs have mostly this one, and call it without a look at the virtual table.
    PhaseValue Evaluate(Vec3 wo, Vec3 wi) const override {
        return SymmetricPhase(ValueAt(OneMinusCos(Axis(wo), wi)));
    }
    /// p at an angle to the lobe's axis, which is -wo or, if the lobe is a backward one, wo.
    float ValueAt(float oneMinusCos) const {
        // 1 + g^2 - 2 |g| cos about the axis of the lobe, without cancellation.
        const float d = Sqr(1 - absG_) + 2 * absG_ * oneMinusCos;
        return Inv4Pi * (1 - absG_) * (1 + absG_) / (d * std::sqrt(d));
    }
    bool IsForward() const { return isForward_; }
    [[gnu::always_inline]] PhaseSample Sample(Vec3 wo, Rng& rng) const override {
        // The textbook inverse of the distribution function has 1/g; solved for 1 - cos it has not, and holds
        // at g = 0 as it stands.
        const Point2 u = rng.Uniform2D();
        const float a = absG_, over = 1 / (1 - a + 2 * a * (1 - u.x));
        const float oneMinusCos = 2 * Sqr((1 - a) * over) * u.x * (1 + a - a * u.x);
        return PhaseRecord(*this, wo, AroundAxis(Axis(wo), std::min(oneMinusCos, 2.f), u.y));
    }

  private:
    Vec3 Axis(Vec3 wo) const { return isForward_ ? -wo : wo; }

    float absG_;
    bool isForward_;
};

/// Makes it with the mean cosine `g` (not null).
std::unique_ptr<PhaseModel> MakeHenyeyGreensteinPhaseModel(const FloatTexture* g);

}  // namespace lacquer
