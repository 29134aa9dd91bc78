// Reflection by a surface of rough diffuse facets.
#pragma once

#include "pbrt/base/bxdf.h"

namespace lacquer {

/// Oren and Nayar's surface in the form of Fujii, with the light that it loses between facets given back:
/// white reflects everything, at any roughness [Portsmouth et al. 2025]. Reciprocal; both sides alike.
class RoughDiffuseBxDF final : public BxDF {
  public:
    /// @param reflectance  of the facets, in [0,1]
    /// @param roughness    in [0,1]; 0: Lambertian
    RoughDiffuseBxDF(SampledSpectrum reflectance, float roughness);

    Lobes Flags() const override { return reflectance_ ? Lobes::DiffuseReflection : Lobes::None; }
    BxDFValue Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const override;
    std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const override;

  private:
    /// f pi.
    SampledSpectrum Scaled(Vec3 wo, Vec3 wi) const;
    /// Part of the light from an angle that white facets send out again after one reflection.
    float SingleAlbedo(float cosTheta) const;

    SampledSpectrum reflectance_, rescattered_;  ///< facets; all further reflections
    float roughness_, scale_;
};

}  // namespace lacquer
