// Interference of light in a film on the boundary of two media.
#pragma once

#include "pbrt/core/sampled_spectrum.h"

namespace lacquer {

/// Thickest film [nm]: at a tenth of a millimetre the fringes are a hundred times closer than the eye's
/// curves are wide.
inline constexpr float kMaxFilmThickness = 1e5f;

/// A film of constant thickness on the boundary of two media, at the wavelengths of a path.
class ThinFilm {
  public:
    /// @param thickness  [nm], in (0, kMaxFilmThickness]
    /// @param eta, k     complex index relative to the vacuum; eta in [1e-3, 1e3], k in [0, 1e6]
    /// @param lambda     in the vacuum [nm]
    /// @param etaAbove   index of the medium above, > 0
    ThinFilm(float thickness, SampledSpectrum eta, SampledSpectrum k, SampledSpectrum lambda, float etaAbove);

    /// The same film, `factor` times as thick, to the rounding of a float. @param factor  > 0
    ThinFilm Scaled(float factor) const {
        ThinFilm film = *this;
        film.quarters_ *= factor;
        film.quartersRest_ *= factor;
        return film;
    }

    /// Parts of the energy; they add up to 1 but for what the film absorbs.
    struct Shares {
        SampledSpectrum reflected, transmitted;
    };
    /// Of an unpolarised ray that arrives from above, or from below.
    /// @param cosTheta_i  as for FresnelDielectric(): negative for a ray from below
    /// @param eta         index below over index above, > 0; without dispersion, as refraction has it
    /// Source: Airy's sum over all internal reflections [Born and Wolf 1999, sec. 7.6 and 14.4], for both
    /// polarisations. Transmission is the same from both sides, reflection is not where the film absorbs.
    Shares OnDielectric(float cosTheta_i, float eta) const;
    /// A metal under the film: what does not depend on the angle.
    struct Metal {
        SampledSpectrum eta, k;  ///< relative to the vacuum
        SampledSpectrum index2Re, index2Im, inverse2Re, inverse2Im;
        bool isModerate;  ///< floats hold products of all indices
    };
    /// @param eta, k  complex index of the metal over the index above
    Metal MetalUnder(SampledSpectrum eta, SampledSpectrum k) const;
    /// Reflectance of the film on metal, from above. @param cosTheta_i  in [0, 1]
    SampledSpectrum OnConductor(float cosTheta_i, const Metal& metal) const;
    SampledSpectrum OnConductor(float cosTheta_i, SampledSpectrum eta, SampledSpectrum k) const {
        return OnConductor(cosTheta_i, MetalUnder(eta, k));
    }

  private:
    float etaAbove_;
    bool absorbs_;
    bool isModerate_;  ///< floats hold products of its indices and that above
    SampledSpectrum eta_, k_;
    SampledSpectrum index2Re_, index2ReRest_;  ///< real part of the squared index, rounded, and the rest
    SampledSpectrum index2Im_;                 ///< a little more than 0 where it is 0
    SampledSpectrum inverse2Re_, inverse2Im_, inverse4Re_,
        inverse4Im_;  ///< 1 over its second and fourth power
    /// What a passage to the bottom of the film and back adds to the phase of a wave whose normal component
    /// is 1, in quarters of a turn: rounded, and the rest.
    SampledSpectrum quarters_, quartersRest_;
};

}  // namespace lacquer
