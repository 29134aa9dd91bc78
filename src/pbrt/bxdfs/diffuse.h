// Lambertian reflection.
#pragma once

#include "pbrt/base/bxdf.h"

namespace lacquer {

/// f = R/pi on the side of wo; both sides of the surface reflect alike.
class DiffuseBxDF final : public BxDF {
  public:
    /// @param reflectance  in [0,1]
    explicit DiffuseBxDF(SampledSpectrum reflectance) : reflectance_(reflectance) {}

    Lobes Flags() const override { return reflectance_ ? Lobes::DiffuseReflection : Lobes::None; }
    BxDFValue Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const override;
    std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const override;
    SurfaceModel Model() const override { return LambertianSurface{reflectance_}; }

  private:
    SampledSpectrum reflectance_;
};

}  // namespace lacquer
