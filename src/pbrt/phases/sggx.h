// Phase function "sggx": microflakes with the normals of an ellipsoid.
#pragma once

#include "pbrt/base/phase_function.h"

namespace lacquer {

/// Flakes with the normals of an ellipsoid of revolution [Heitz et al. 2015], with the axis t and the matrix
/// S. Extinction(w) = sqrt(w^T S w), at most 1; p = D(h) / (4 Extinction(wo)). Weight 1.
class SggxPhase final : public PhaseFunction {
  public:
    static constexpr float kMinRoughness = 1e-3f;

    /// @param orientation  t: the direction of a fibre or the normal of a sheet; any length, z if it has none
    /// @param roughness    r; clamped to [kMinRoughness, 1]. 1: flakes of all directions
    /// @param isSurface    S has the eigenvalues r^2, r^2, and 1 along t (sheets); else 1, 1, and r^2
    /// (fibres)
    SggxPhase(Vec3 orientation, float roughness, bool isSurface);

    PhaseValue Evaluate(Vec3 wo, Vec3 wi) const override;
    PhaseSample Sample(Vec3 wo, Rng& rng) const override;
    float Extinction(Vec3 w) const override;
    bool HasDirectionalExtinction() const override { return true; }

  private:
    float LocalExtinction(Vec3 w) const;
    PhaseValue LocalEvaluate(Vec3 wo, Vec3 wi) const;

    Frame frame_;           ///< z is t
    float across_, along_;  ///< roots of the eigenvalues of S
};

}  // namespace lacquer
