// Media of oriented mirrors (microflakes): extinction and scattering depend on the direction [Jakob et al.
// 2010]. The flakes are two-sided specular mirrors that lose nothing; losses are the medium's albedo.
//
// Both are reciprocal: Extinction(wo) p(wo, wi) is a function of the half vector alone.
#pragma once

#include "pbrt/base/phase_function.h"
#include "pbrt/media/fibre_extinction.h"

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
