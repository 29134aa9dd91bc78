// Reflection and refraction at the boundary of a transparent medium, polished or rough, with a thin film or
// without.
#pragma once

#include <optional>

#include "pbrt/base/bxdf.h"
#include "pbrt/scattering/microfacet.h"
#include "pbrt/scattering/thin_film.h"

namespace lacquer {

/// The boundary itself, by Fresnel's equations.
class BareDielectric {
  public:
    static constexpr bool kIsBare = true;
    /// Parts of the energy.
    struct Shares {
        float reflected, transmitted;
    };

    /// @param eta  index below the surface (z < 0) over index above it, in [1e-3, 1e3]
    BareDielectric(float eta) : eta_(eta) {}  // NOLINT: an index is a boundary
    float Eta() const { return eta_; }
    /// @param cosTheta_i  negative for light from below
    Shares At(float cosTheta_i) const {
        const float fresnel = eta_ == 1 ? 0.f : FresnelDielectric(cosTheta_i, eta_);
        return {fresnel, 1 - fresnel};
    }
    /// The probability of reflection.
    static float ReflectionShare(const Shares& shares) { return shares.reflected; }

  private:
    float eta_;
};

/// The same with a film on it, which does not change where light is refracted to.
class FilmedDielectric {
  public:
    static constexpr bool kIsBare = false;
    using Shares = ThinFilm::Shares;

    /// @param film  whose index above is that above the surface
    FilmedDielectric(float eta, const ThinFilm& film) : eta_(eta), film_(film) {}
    float Eta() const { return eta_; }
    Shares At(float cosTheta_i) const { return film_.OnDielectric(cosTheta_i, eta_); }
    /// What a film absorbs counts here: transmission then is as probable one way as the other.
    static float ReflectionShare(const Shares& shares) { return 1 - shares.transmitted.Average(); }

  private:
    float eta_;
    ThinFilm film_;
};

/// A boundary whose reflection from above is tinted, which no real one does, with a film or without. What the
/// tint takes away is lost.
class TintedDielectric {
  public:
    static constexpr bool kIsBare = false;
    using Shares = ThinFilm::Shares;

    /// @param reflection    tint of what is reflected from above
    /// @param transmission  of what passes, either way
    TintedDielectric(float eta, const std::optional<ThinFilm>& film, SampledSpectrum reflection,
                     SampledSpectrum transmission)
        : eta_(eta), film_(film), reflection_(reflection), transmission_(transmission) {}
    float Eta() const { return eta_; }
    Shares At(float cosTheta_i) const {
        Shares shares;
        if (film_) {
            shares = film_->OnDielectric(cosTheta_i, eta_);
        } else {
            const BareDielectric::Shares bare = BareDielectric(eta_).At(cosTheta_i);
            shares = {SampledSpectrum(bare.reflected), SampledSpectrum(bare.transmitted)};
        }
        if (cosTheta_i > 0) shares.reflected *= reflection_;
        shares.transmitted *= transmission_;
        return shares;
    }
    static float ReflectionShare(const Shares& shares) { return FilmedDielectric::ReflectionShare(shares); }

  private:
    float eta_;
    std::optional<ThinFilm> film_;
    SampledSpectrum reflection_, transmission_;
};

/// Fresnel reflection and refraction, at microfacets [Walter et al. 2007] or, where the alphas are smooth or
/// the index is 1, as specular lobes. Scattered once: the energy of further bounces between facets is lost.
/// Between media of one index, where refraction has no facets to choose, a film is smooth, too.
template <MicrofacetDistribution Distribution, class Boundary>
class DielectricBxDFOf final : public BxDF {
  public:
    DielectricBxDFOf(Alphas alphas, const Boundary& boundary)
        : facets_(alphas.x, alphas.y),
          boundary_(boundary),
          isSpecular_(boundary.Eta() == 1 || alphas.IsSmooth()) {}

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
    /// @param share  of reflection, where both sides are asked for
    static SideProbabilities ProbabilitiesOf(float share, Lobes sides);
    /// Index on the other side over index on the side of w.
    float IndexAcross(Vec3 w) const { return w.z > 0 ? boundary_.Eta() : 1 / boundary_.Eta(); }
    /// The normal of a facet that wo sees, on the side of z > 0.
    Vec3 SampleFacet(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const;
    std::optional<BxDFSample> SampleSpecular(Vec3 wo, const BxDFRandom& u, const BxDFContext& context) const;
    std::optional<BxDFSample> SampleWithoutPdf(Vec3 wo, Vec3 wm, float uLobe,
                                               const BxDFContext& context) const;
    std::optional<BxDFSample> SampleReflection(Vec3 wo, Vec3 wi, const BxDFContext& context) const;
    std::optional<BxDFSample> SampleTransmission(Vec3 wo, Vec3 wi, const BxDFContext& context) const;

    Distribution facets_;
    Boundary boundary_;
    bool isSpecular_;
};

template <MicrofacetDistribution Distribution>
using DielectricBxDF = DielectricBxDFOf<Distribution, BareDielectric>;
template <MicrofacetDistribution Distribution>
using FilmedDielectricBxDF = DielectricBxDFOf<Distribution, FilmedDielectric>;
template <MicrofacetDistribution Distribution>
using TintedDielectricBxDF = DielectricBxDFOf<Distribution, TintedDielectric>;

extern template class DielectricBxDFOf<TrowbridgeReitz, BareDielectric>;
extern template class DielectricBxDFOf<Beckmann, BareDielectric>;
extern template class DielectricBxDFOf<TrowbridgeReitz, FilmedDielectric>;
extern template class DielectricBxDFOf<Beckmann, FilmedDielectric>;
extern template class DielectricBxDFOf<TrowbridgeReitz, TintedDielectric>;

}  // namespace lacquer
