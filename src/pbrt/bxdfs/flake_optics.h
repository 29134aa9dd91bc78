// What a flake of a paint does to light.
#pragma once

#include <optional>

#include "pbrt/scattering/thin_film.h"

namespace lacquer {

/// A flake as a mirror: of metal, or a plate of a clear material (a pearl flake), with films of interference
/// on its faces or without. What does not get reflected by metal is absorbed; by a plate it goes straight on.
class FlakeOptics {
  public:
    /// Films that differ from flake to flake have one of so many thicknesses, each as often as the others.
    static constexpr int kThicknesses = 8;

    /// @param eta, k  complex index of the metal over that around the flakes, in [0, 1e6]
    /// @param film    whose index above is that around the flakes
    /// @param spread  standard deviation of the film's thickness from flake to flake, over its mean, in [0,
    /// 0.5]
    static FlakeOptics Metal(SampledSpectrum eta, SampledSpectrum k, const std::optional<ThinFilm>& film,
                             float spread);
    /// @param eta   index of the plate over that around it, > 0
    /// @param film  on both faces; must not absorb
    static FlakeOptics Plate(float eta, const std::optional<ThinFilm>& film, float spread);

    /// How many kinds of flakes there are: 1 or kThicknesses.
    int NumKinds() const { return film_ && spread_ > 0 ? kThicknesses : 1; }
    /// Of light that meets the face of a flake of a kind in [0, NumKinds()). @param cosTheta_i  in [0, 1]
    SampledSpectrum Reflectance(float cosTheta_i, int kind) const;
    /// The mean over the kinds.
    SampledSpectrum MeanReflectance(float cosTheta_i) const;
    /// True if what is not reflected goes on.
    bool Transmits() const { return isPlate_; }

  private:
    FlakeOptics(const std::optional<ThinFilm>& film, float spread) : film_(film), spread_(spread) {}

    std::optional<ThinFilm> film_;
    float spread_;
    bool isPlate_ = false;
    float plateEta_ = 1;
    SampledSpectrum eta_, k_;  ///< of metal without a film
    std::optional<ThinFilm::Metal> metalUnderFilm_;
};

}  // namespace lacquer
