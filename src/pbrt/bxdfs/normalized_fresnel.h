// How light leaves a scattering medium: diffuse, but for what the boundary reflects.
#pragma once

#include "pbrt/base/bxdf.h"

namespace lacquer {

/// f = (1 - Fr(cos theta_i, eta)) / (pi (1 - 2 F1(1/eta))) on the side of wo, so that f cos theta_i
/// integrates to 1; times eta^2 in radiance mode, where the refraction at the entry lost it. Depends on wi
/// only: it stands for one half of a path whose other half is elsewhere, and alone it has no adjoint.
class NormalizedFresnelBxDF final : public BxDF {
  public:
    /// @param eta  index inside over index outside, in [0.4, 2.5]: where the moments are good
    explicit NormalizedFresnelBxDF(float eta);

    Lobes Flags() const override { return Lobes::DiffuseReflection; }
    BxDFValue Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const override;
    std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const override;

  private:
    /// pi f.
    float Albedo(float cosTheta_i, TransportMode mode) const;

    float eta_, normalization_;
};

}  // namespace lacquer
