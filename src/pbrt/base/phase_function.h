// How a medium scatters light at a point inside it.
#pragma once

#include "pbrt/core/rng.h"
#include "pbrt/core/vec.h"

namespace lacquer {

/// Value and densities for one pair of directions.
struct PhaseValue {
    float p = 0;           ///< [1/sr]; integrates to 1 over wi
    float pdf = 0;         ///< [1/sr], over wi, of what Sample() draws for wo
    float pdfReverse = 0;  ///< [1/sr], over wo, of drawing wo for wi
};

/// A direction drawn by Sample().
struct PhaseSample {
    Vec3 wi{0, 0, 1};
    float weight = 1;  ///< p / pdf
    float pdf = 0, pdfReverse = 0;
};

/// Scattering in a medium, for wo and wi that both point away from the point (straight on is wi = -wo).
/// Objects hold numbers only, live in an Arena and are trivially destructible; all functions are const and
/// thread-safe.
///
/// Reciprocity: Extinction(wo) p(wo, wi) = Extinction(wi) p(wi, wo). Media whose extinction does not depend
/// on the direction have a symmetric p.
class PhaseFunction {
  public:
    virtual PhaseValue Evaluate(Vec3 wo, Vec3 wi) const = 0;
    /// Draws wi; never fails. Takes as many numbers as it needs.
    virtual PhaseSample Sample(Vec3 wo, Rng& rng) const = 0;
    /// Extinction along w in units of the medium's sigma_t: the projected area of its flakes. Even in w.
    virtual float Extinction(Vec3 /*w*/) const { return 1; }
    /// True if Extinction() is not 1 everywhere.
    virtual bool HasDirectionalExtinction() const { return false; }

  protected:
    ~PhaseFunction() = default;  // never destroyed through the base: the arena forgets objects
};

}  // namespace lacquer
