// What captured materials have: a Lambertian lobe under a GGX lobe with a coloured reflectance.
#pragma once

#include "pbrt/base/bxdf.h"
#include "pbrt/scattering/trowbridge_reitz.h"

namespace lacquer {

/// The model that maps of photographs are fitted by [Guo et al. 2020b], with its own Fresnel factor and
/// masking, and with the constants that it adds to denominators: what was fitted is what is rendered.
/// Reciprocal; both sides alike.
class SvbrdfBxDF final : public BxDF {
  public:
    /// @param albedo    of the Lambertian lobe, in [0,1], where the other one lets light through
    /// @param specular  reflectance at normal incidence, in [0,1]
    /// @param alpha     of GGX; clamped to [1e-3, 1]: below 0.035 the model's lobe fades away
    /// @param conserve  the Lambertian lobe gets what Fresnel's factor leaves at the angles of both
    /// directions;
    ///                  false: at normal incidence, as published, so that white surfaces reflect more than
    ///                  arrives at grazing angles
    SvbrdfBxDF(SampledSpectrum albedo, SampledSpectrum specular, float alpha, bool conserve);

    Lobes Flags() const override { return Lobes::DiffuseReflection | Lobes::GlossyReflection; }
    BxDFValue Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const override;
    std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const override;
    void Regularize() override;

  private:
    /// Probability that a draw for a direction with this cosine is of the GGX lobe.
    float GlossyShare(float cosTheta) const;

    SampledSpectrum diffuse_, specular_;  ///< albedo (1 - specular)
    float meanDiffuse_, meanSpecular_, glossyEnergy_;
    TrowbridgeReitz facets_;
    bool conserve_;
};

}  // namespace lacquer
