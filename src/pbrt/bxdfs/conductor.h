// Reflection by metal, polished or rough, with a thin film or without.
#pragma once

#include <concepts>

#include "pbrt/base/bxdf.h"
#include "pbrt/scattering/microfacet.h"
#include "pbrt/scattering/thin_film.h"

namespace lacquer {

/// The metal itself, by Fresnel's equations.
class BareMetal {
  public:
    /// @param eta, k  complex index relative to the outside, in [0, 1e6]
    BareMetal(SampledSpectrum eta, SampledSpectrum k) : eta_(eta), k_(k) {}
    /// @param cosTheta_i  in [0, 1]
    SampledSpectrum Reflectance(float cosTheta_i) const { return FresnelConductor(cosTheta_i, eta_, k_); }

  private:
    SampledSpectrum eta_, k_;
};

/// The same under a film.
class FilmedMetal {
  public:
    /// @param film  whose index above is that of the outside
    FilmedMetal(SampledSpectrum eta, SampledSpectrum k, const ThinFilm& film)
        : film_(film), metal_(film.MetalUnder(eta, k)) {}
    SampledSpectrum Reflectance(float cosTheta_i) const { return film_.OnConductor(cosTheta_i, metal_); }

  private:
    ThinFilm film_;
    ThinFilm::Metal metal_;
};

/// Metal by its colours: at normal incidence, and at 82 degrees, where that of metals has its dip, in parts
/// of Schlick's approximation there [Kutz et al. 2021].
class TintedMetal {
  public:
    /// @param normal  reflectance at normal incidence, @param tint  of that at 82 degrees: each in [0, 1]
    /// @param scale   of the whole, in [0, 1]
    TintedMetal(SampledSpectrum normal, SampledSpectrum tint, float scale) : normal_(normal), scale_(scale) {
        constexpr float kCosine = 1.f / 7;
        constexpr float kPower5 = 7776.f / 16807;  // (1 - kCosine)^5
        dip_ = (normal + (1 - normal) * kPower5) * (1 - tint) / (kCosine * (1 - kCosine) * kPower5);
    }
    /// @param cosTheta_i  in [0, 1]
    SampledSpectrum Reflectance(float cosTheta_i) const {
        const float c = std::min(cosTheta_i, 1.f), m = 1 - c, m2 = m * m, m5 = m2 * m2 * m;
        return scale_ * Clamp(normal_ + (1 - normal_) * m5 - dip_ * (c * m5 * m), 0, 1);
    }

  private:
    SampledSpectrum normal_, dip_;
    float scale_;
};

/// Reflection at microfacets, scattered once (the energy of further bounces is lost); a mirror where the
/// alphas are smooth. Both sides of the surface reflect alike.
template <MicrofacetDistribution Distribution, class Metal>
class ConductorBxDFOf final : public BxDF {
  public:
    ConductorBxDFOf(Alphas alphas, const Metal& metal)
        : facets_(alphas.x, alphas.y), metal_(metal), isSmooth_(alphas.IsSmooth()) {}
    /// @param eta, k  as for BareMetal. A template, for Clang 14 makes the others with each instance of the
    /// class, whether it has them or not.
    template <std::same_as<SampledSpectrum> Spectrum>
    requires std::same_as<Metal, BareMetal> ConductorBxDFOf(Alphas alphas, Spectrum eta, Spectrum k)
        : ConductorBxDFOf(alphas, BareMetal(eta, k)) {}

    Lobes Flags() const override { return isSmooth_ ? Lobes::SpecularReflection : Lobes::GlossyReflection; }
    BxDFValue Evaluate(Vec3 wo, Vec3 wi, const BxDFContext& context) const override;
    std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const override;
    SurfaceModel Model() const override;
    void Regularize() override;

  private:
    /// The normal of a facet that wo sees, on the side of z > 0.
    Vec3 SampleFacet(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const;

    Distribution facets_;
    Metal metal_;
    bool isSmooth_;
};

template <MicrofacetDistribution Distribution>
using ConductorBxDF = ConductorBxDFOf<Distribution, BareMetal>;
template <MicrofacetDistribution Distribution>
using FilmedConductorBxDF = ConductorBxDFOf<Distribution, FilmedMetal>;
template <MicrofacetDistribution Distribution>
using TintedConductorBxDF = ConductorBxDFOf<Distribution, TintedMetal>;

extern template class ConductorBxDFOf<TrowbridgeReitz, BareMetal>;
extern template class ConductorBxDFOf<Beckmann, BareMetal>;
extern template class ConductorBxDFOf<TrowbridgeReitz, FilmedMetal>;
extern template class ConductorBxDFOf<Beckmann, FilmedMetal>;
extern template class ConductorBxDFOf<TrowbridgeReitz, TintedMetal>;

}  // namespace lacquer
