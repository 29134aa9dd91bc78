// Phase function "fibre": microflakes around fibres.
#pragma once

#include "pbrt/base/phase_function.h"
#include "pbrt/phases/fibre_extinction.h"

namespace lacquer {

/// Flakes around fibres: D(m) = C exp(-(t.m)^2 / (2 s^2)) over the sphere with integral 1 [Zhao et al. 2011].
/// Extinction(w) = integral |w.m| D(m) dm: 1/2 for a large s, 2/pi across and s sqrt(2/pi) along thin fibres.
/// A medium's sigma_t is thus the area of its flakes (one side) per volume, and not the extinction along any
/// one direction; where a publication gives a "density" beside fibres, it is this. p = D(h) / (2
/// Extinction(wo)): twice what SGGX has, for this D counts both sides of each flake. Weight 1.
class FibrePhase final : public PhaseFunction {
  public:
    /// @param orientation  t; any length, z if it has none
    /// @param stddev       s, of the cosine between normal and fibre; clamped as in FibreExtinction
    FibrePhase(Vec3 orientation, float stddev);

    PhaseValue Evaluate(Vec3 wo, Vec3 wi) const override;
    PhaseSample Sample(Vec3 wo, Rng& rng) const override;
    float Extinction(Vec3 w) const override;
    bool HasDirectionalExtinction() const override { return true; }

  private:
    float LocalExtinction(Vec3 w) const { return extinction_(w.x * w.x + w.y * w.y, w.z * w.z); }
    PhaseValue LocalEvaluate(Vec3 wo, Vec3 wi) const;
    Vec3 SampleVisibleFlake(Vec3 wo, Rng& rng) const;
    float SampleCosineAlong(Rng& rng) const;
    float SampleCosineAcross(Rng& rng) const;

    Frame frame_;  ///< z is t
    FibreExtinction extinction_;
    float exponent_;  ///< 1 / (2 s^2)
};

}  // namespace lacquer
