// A thin plate of glass: two parallel smooth boundaries at once.
#pragma once

#include "pbrt/base/bxdf.h"

namespace lacquer {

/// Mirror reflection and undeviated transmission, summed over all bounces inside the plate.
class ThinDielectricBxDF final : public BxDF {
  public:
    /// @param eta  index of the plate over index around it, in [1e-3, 1e3]
    explicit ThinDielectricBxDF(float eta) : eta_(eta) {}

    Lobes Flags() const override { return Lobes::BothSides | Lobes::Specular; }
    /// Zero: both lobes are specular.
    BxDFValue Evaluate(Vec3, Vec3, const BxDFContext&) const override { return {}; }
    std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const override;

  private:
    float eta_;
};

}  // namespace lacquer
