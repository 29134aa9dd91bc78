// Reflection and refraction at the boundary of a transparent medium, polished or rough.
#pragma once

#include "pbrt/base/bxdf.h"
#include "pbrt/scattering/microfacet.h"

namespace lacquer {

/// Fresnel reflection and refraction, at microfacets [Walter et al. 2007] or, where the alphas are smooth or
/// the index is 1, as specular lobes. Scattered once: the energy of further bounces between facets is lost.
template <MicrofacetDistribution Distribution>
class DielectricBxDF final : public BxDF {
  public:
    /// @param eta  index below the surface (z < 0) over index above it, in [1e-3, 1e3]
    DielectricBxDF(Alphas alphas, float eta)
        : facets_(alphas.x, alphas.y), eta_(eta), isSpecular_(eta == 1 || alphas.IsSmooth()) {}

    Lobes Flags() const override;
    BxDFValue Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const override;
    std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const override;
    SurfaceModel Model() const override;
    void Regularize() override;

  private:
    /// Probabilities of the two sides when one is drawn by energy among those asked for; both 0 if none is
    /// left.
    struct SideProbabilities {
        float reflection, transmission;
    };
    static SideProbabilities ProbabilitiesOf(float fresnel, Lobes sides);
    /// Index on the other side over index on the side of w.
    float IndexAcross(Vec3 w) const { return w.z > 0 ? eta_ : 1 / eta_; }
    /// The normal of a facet that wo sees, on the side of z > 0.
    Vec3 SampleFacet(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const;
    std::optional<BxDFSample> SampleSpecular(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const;
    std::optional<BxDFSample> SampleReflection(Vec3 wo, Vec3 wi, const BxDFContext& context) const;
    std::optional<BxDFSample> SampleTransmission(Vec3 wo, Vec3 wi, const BxDFContext& context) const;

    Distribution facets_;
    float eta_;
    bool isSpecular_;
};

extern template class DielectricBxDF<TrowbridgeReitz>;
extern template class DielectricBxDF<Beckmann>;

}  // namespace lacquer
