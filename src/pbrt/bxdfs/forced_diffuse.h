// Any model as a matte one of the same albedo: the option "forcediffuse".
#pragma once

#include "pbrt/base/bxdf.h"

namespace lacquer {

/// f = R(w)/pi on the side of wo, where R(w) is the part of the light that another model scatters, reflected
/// and transmitted together, for the direction w on the camera's side. As in pbrt-v4, R comes from one draw
/// of that model and is right in expectation only, and transmitted radiance has its 1/eta^2. Cost: one draw
/// for each query.
class ForcedDiffuseBxDF final : public BxDF {
  public:
    /// @param model  lives as long as this
    explicit ForcedDiffuseBxDF(const BxDF* model) : model_(model) {}

    Lobes Flags() const override {
        return model_->Flags() == Lobes::None ? Lobes::None : Lobes::DiffuseReflection;
    }
    BxDFValue Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const override;
    float Pdf(Vec3 wo, Vec3 wi, const BxDFContext& context) const override;
    std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const override;

  private:
    SampledSpectrum SampleAlbedo(Vec3 wo, Vec3 wi, const BxDFContext& context) const;
    const BxDF* model_;
};

}  // namespace lacquer
