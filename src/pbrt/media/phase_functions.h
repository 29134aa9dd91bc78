// Phase functions that depend on the scattering angle only, and the mixture of any. All are symmetric, exact
// to sample (weight 1), and cheap to make at each hit.
#pragma once

#include <span>
#include <vector>

#include "pbrt/base/phase_function.h"

namespace lacquer {

/// The same in all directions.
class IsotropicPhase final : public PhaseFunction {
  public:
    PhaseValue Evaluate(Vec3 wo, Vec3 wi) const override;
    PhaseSample Sample(Vec3 wo, Rng& rng) const override;
};

/// p = (1 - g^2) / (4 pi (1 + g^2 - 2 g cos)^1.5), cos = 1 straight on [Henyey and Greenstein 1941]. Written
/// with 1 - cos, so that narrow lobes keep their digits.
class HenyeyGreensteinPhase final : public PhaseFunction {
  public:
    /// Narrower lobes are narrower than float directions can say.
    static constexpr float kMaxG = 0.9999f;

    /// @param g  mean cosine, positive forward; clamped to [-kMaxG, kMaxG], NaN becomes 0
    explicit HenyeyGreensteinPhase(float g);

    PhaseValue Evaluate(Vec3 wo, Vec3 wi) const override;
    PhaseSample Sample(Vec3 wo, Rng& rng) const override;

  private:
    Vec3 Axis(Vec3 wo) const { return isForward_ ? -wo : wo; }

    float absG_;
    bool isForward_;
};

/// p = kappa exp(kappa cos) / (4 pi sinh kappa), cos = 1 straight on: the von Mises-Fisher distribution, also
/// called normalised exponential. Mean cosine coth(kappa) - 1/kappa.
class VonMisesFisherPhase final : public PhaseFunction {
  public:
    static constexpr float kMaxKappa = 1e6f;

    /// @param kappa  concentration, 0 isotropic; clamped to [0, kMaxKappa], NaN becomes 0
    explicit VonMisesFisherPhase(float kappa);

    PhaseValue Evaluate(Vec3 wo, Vec3 wi) const override;
    PhaseSample Sample(Vec3 wo, Rng& rng) const override;

  private:
    float kappa_;
    float tail_;  ///< exp(-2 kappa) - 1
    float peak_;  ///< p straight on [1/sr]
};

/// A function of the cosine c of the scattering angle from numbers: made once with a material, shared by its
/// hits.
struct PhaseTable {
    /// @param samples  at least 2, at equal steps of c from -1 (straight back) to 1 (straight on), linear
    ///                 between; in any unit. What is negative or not finite counts as 0; if nothing is left,
    ///                 the table is isotropic.
    explicit PhaseTable(std::span<const float> samples);

    std::vector<float> values;  ///< p [1/sr]
    std::vector<float> cdf;     ///< probability of a cosine below that of the sample, 0 ... 1
};

/// Reads a PhaseTable, which must outlive it.
class TabulatedPhase final : public PhaseFunction {
  public:
    explicit TabulatedPhase(const PhaseTable& table) : TabulatedPhase(table.values, table.cdf) {}
    /// The two arrays of a PhaseTable.
    TabulatedPhase(std::span<const float> values, std::span<const float> cdf);

    PhaseValue Evaluate(Vec3 wo, Vec3 wi) const override;
    PhaseSample Sample(Vec3 wo, Rng& rng) const override;

  private:
    std::span<const float> values_, cdf_;
};

/// Several kinds of particles in one medium, part i making up the share w_i = weight_i / (sum of weights).
/// Extinctions add up, Extinction(w) = sum w_i Extinction_i(w), and a particle is hit in proportion to what
/// it adds: p = sum w_i Extinction_i(wo) p_i / Extinction(wo). So the mixture is reciprocal if its parts are.
class MixturePhase final : public PhaseFunction {
  public:
    /// Parts and weights must outlive the object. At least one part, as many weights as parts. Weights that
    /// are negative or NaN count as 0; if all are 0, the parts have equal shares.
    MixturePhase(std::span<const PhaseFunction* const> parts, std::span<const float> weights);

    PhaseValue Evaluate(Vec3 wo, Vec3 wi) const override;
    PhaseSample Sample(Vec3 wo, Rng& rng) const override;
    float Extinction(Vec3 w) const override;
    bool HasDirectionalExtinction() const override { return isDirectional_; }

  private:
    float Share(size_t i) const;
    /// What part i adds to Extinction(w).
    float PartExtinction(size_t i, Vec3 w) const;

    std::span<const PhaseFunction* const> parts_;
    std::span<const float> weights_;
    float scale_ = 0;  ///< 1 / sum of weights; 0: equal shares
    bool isDirectional_ = false;
};

}  // namespace lacquer
