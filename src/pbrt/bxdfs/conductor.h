// Reflection by metal, polished or rough.
#pragma once

#include "pbrt/base/bxdf.h"
#include "pbrt/scattering/microfacet.h"

namespace lacquer {

/// Complex Fresnel reflection at microfacets, scattered once (the energy of further bounces is lost); a
/// mirror where the alphas are smooth. Both sides of the surface reflect alike.
template <MicrofacetDistribution Distribution>
class ConductorBxDF final : public BxDF {
  public:
    /// @param eta, k  complex index relative to the outside, in [0, 1e6]
    ConductorBxDF(Alphas alphas, SampledSpectrum eta, SampledSpectrum k)
        : facets_(alphas.x, alphas.y), eta_(eta), k_(k), isSmooth_(alphas.IsSmooth()) {}

    Lobes Flags() const override { return isSmooth_ ? Lobes::SpecularReflection : Lobes::GlossyReflection; }
    BxDFValue Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const override;
    std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const override;
    SurfaceModel Model() const override;
    void Regularize() override;

  private:
    /// The normal of a facet that wo sees, on the side of z > 0.
    Vec3 SampleFacet(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const;

    Distribution facets_;
    SampledSpectrum eta_, k_;
    bool isSmooth_;
};

extern template class ConductorBxDF<TrowbridgeReitz>;
extern template class ConductorBxDF<Beckmann>;

}  // namespace lacquer
