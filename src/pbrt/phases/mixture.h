// Phase function "mixture": of several kinds of particles.
#pragma once

#include "pbrt/base/phase_function.h"

namespace lacquer {

/// Several kinds of particles in one medium, part i making up the share w_i = weight_i / (sum of weights).
/// Extinctions add up, Extinction(w) = sum w_i Extinction_i(w), and so does what is scattered, S_i(w) = w_i
/// Extinction_i(w) Albedo_i(w): p = sum S_i(wo) p_i / sum S_i(wo). So the mixture is reciprocal if its parts
/// are.
class MixturePhase final : public PhaseFunction {
  public:
    /// Parts and weights must outlive the object. At least one part, as many weights as parts. Weights that
    /// are negative or NaN count as 0; if all are 0, the parts have equal shares.
    /// @param lambda  that the parts were made with
    MixturePhase(std::span<const PhaseFunction* const> parts, std::span<const float> weights,
                 const SampledWavelengths& lambda = {});

    PhaseValue Evaluate(Vec3 wo, Vec3 wi) const override;
    PhaseSample Sample(Vec3 wo, Rng& rng) const override;
    bool IsChromatic() const override { return isChromatic_; }
    SpectralPhaseValue EvaluateSpectral(Vec3 wo, Vec3 wi) const override;
    Vec3 SampleAt(int wavelength, Vec3 wo, Rng& rng) const override;
    float Extinction(Vec3 w) const override;
    float Albedo(Vec3 w) const override;
    bool HasDirectionalExtinction() const override { return isDirectional_; }
    bool HasDirectionalAlbedo() const override { return hasAlbedos_; }
    DirectionalFactors FactorsAlong(Vec3 w, const SampledWavelengths& lambda) const override;

  private:
    float Share(size_t i) const;
    /// What part i adds to Extinction(w).
    float PartExtinction(size_t i, Vec3 w) const;
    /// What of it is scattered; at all wavelengths.
    float PartScattering(size_t i, Vec3 w) const;
    SampledSpectrum SpectralPartScattering(size_t i, Vec3 w) const;
    /// The particle that scatters. @param scattering  of part i; @param total  of all
    template <class Scattering>
    const PhaseFunction& SamplePart(Rng& rng, float total, const Scattering& scattering) const;

    std::span<const PhaseFunction* const> parts_;
    std::span<const float> weights_;
    SampledWavelengths lambda_;
    float scale_ = 0;  ///< 1 / sum of weights; 0: equal shares
    bool isDirectional_ = false, isChromatic_ = false, hasAlbedos_ = false;
};

}  // namespace lacquer
