// Lambertian reflection and transmission.
#pragma once

#include "pbrt/base/bxdf.h"

namespace lacquer {

/// f = R/pi on the side of wo, T/pi on the other side; the index does not change.
class DiffuseTransmissionBxDF final : public BxDF {
  public:
    /// @param reflectance, transmittance  in [0,1]; their sum above 1 would make energy
    DiffuseTransmissionBxDF(SampledSpectrum reflectance, SampledSpectrum transmittance)
        : reflectance_(reflectance), transmittance_(transmittance) {}

    Lobes Flags() const override;
    BxDFValue Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const override;
    std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const override;

  private:
    /// Probability of reflection among `sides`; negative if nothing scatters there.
    float ReflectionProbability(Lobes sides) const;

    SampledSpectrum reflectance_, transmittance_;
};

}  // namespace lacquer
