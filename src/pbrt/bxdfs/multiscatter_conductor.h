// Reflection by rough metal with all bounces between its facets.
#pragma once

#include "pbrt/base/bxdf.h"
#include "pbrt/bxdfs/conductor.h"
#include "pbrt/scattering/microsurface.h"

namespace lacquer {

/// ConductorBxDF and the light that meets more than one facet, on the random surface of Smith [Heitz et al.
/// 2016]: a metal that absorbs nothing loses nothing, and others lose at each bounce. Never smooth.
///
/// A value is the closed form of the single reflection plus an estimate of the others, which needs
/// context.rng: a walk from wo or from wi, whose depths are integrated over (DepthFreePath), with a
/// connection at each facet; the two starts are weighted by the balance heuristic. Sample() is the analog
/// walk: its weight is the product of Fresnel's factors. The density is an approximation (pdfExact is false):
/// the exact one of what leaves after one reflection, and a cosine lobe for all else. Positive wherever
/// Sample() draws; its integral is 0.92 to 1.09 up to alphas of 1. Model() is none: product estimators know
/// single reflections only.
template <MicrofacetDistribution Distribution, class Metal>
class MultiscatterConductorBxDFOf final : public BxDF {
  public:
    /// Bounces after which light is lost: less than 1e-4 of it at alphas up to 4. Deeper pits take more: at
    /// an alpha of 10 (Trowbridge and Reitz) a fifth of what comes straight from above is lost.
    static constexpr int kMaxBounces = DepthFreePath::kMaxRays;

    /// @param alphas     not smooth
    /// @param maxBounces  1 to kMaxBounces; fewer lose energy
    MultiscatterConductorBxDFOf(Alphas alphas, const Metal& metal, int maxBounces = kMaxBounces)
        : facets_(alphas.x, alphas.y), metal_(metal), maxBounces_(maxBounces) {}

    /// @param eta, k  as for BareMetal; a template as that of ConductorBxDFOf
    template <std::same_as<SampledSpectrum> Spectrum>
    requires std::same_as<Metal, BareMetal> MultiscatterConductorBxDFOf(Alphas alphas, Spectrum eta,
                                                                        Spectrum k,
                                                                        int maxBounces = kMaxBounces)
        : MultiscatterConductorBxDFOf(alphas, BareMetal(eta, k), maxBounces) {}

    Lobes Flags() const override { return Lobes::GlossyReflection; }
    BxDFValue Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const override;
    float Pdf(Vec3 wo, Vec3 wi, const BxDFContext& context) const override;
    std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const override;
    void Regularize() override;

  private:
    SampledSpectrum Fresnel(float cosTheta) const { return metal_.Reflectance(cosTheta); }
    /// f of two and more bounces, wo and wi above the surface.
    SampledSpectrum EstimateRescattered(Vec3 wo, Vec3 wi, Rng& rng) const;
    /// @param single  f of one reflection without Fresnel's factor
    float DensityOf(float single, Vec3 wo, Vec3 wi) const;

    Distribution facets_;
    Metal metal_;
    int maxBounces_;
};

template <MicrofacetDistribution Distribution>
using MultiscatterConductorBxDF = MultiscatterConductorBxDFOf<Distribution, BareMetal>;
template <MicrofacetDistribution Distribution>
using FilmedMultiscatterConductorBxDF = MultiscatterConductorBxDFOf<Distribution, FilmedMetal>;

template <MicrofacetDistribution Distribution>
using TintedMultiscatterConductorBxDF = MultiscatterConductorBxDFOf<Distribution, TintedMetal>;

extern template class MultiscatterConductorBxDFOf<TrowbridgeReitz, TintedMetal>;
extern template class MultiscatterConductorBxDFOf<TrowbridgeReitz, BareMetal>;
extern template class MultiscatterConductorBxDFOf<Beckmann, BareMetal>;
extern template class MultiscatterConductorBxDFOf<TrowbridgeReitz, FilmedMetal>;
extern template class MultiscatterConductorBxDFOf<Beckmann, FilmedMetal>;

}  // namespace lacquer
