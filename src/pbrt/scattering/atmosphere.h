// The air above the ground: how much of molecules, aerosol and ozone light passes, and what they do to it.
//
// Spherical shells around a planet. Densities are those over the whole vertical column, so that an optical
// depth is that of the vertical column times the number of columns on the way.
#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "pbrt/core/sampled_spectrum.h"

namespace lacquer {

/// Wavelengths at which skies are computed: what the air does is smooth between them.
inline constexpr int kNumSkyWavelengths = 24;
using SkySpectrum = std::array<float, kNumSkyWavelengths>;
/// [nm]
constexpr float SkyWavelength(int i) {
    return kLambdaMin + (kLambdaMax - kLambdaMin) * float(i) / float(kNumSkyWavelengths - 1);
}

/// The two neighbours of a wavelength.
struct SkyBand {
    size_t index;  ///< of the first
    float weight;  ///< of the second
};
inline SkyBand SkyBandOf(float lambda) {
    const float place = std::clamp((lambda - kLambdaMin) / (kLambdaMax - kLambdaMin), 0.f, 1.f) *
                        float(kNumSkyWavelengths - 1);
    const size_t index = std::min(size_t(place), size_t(kNumSkyWavelengths - 2));
    return {index, place - float(index)};
}

/// Of each kind of matter: density [1/km], or numbers of vertical columns.
struct AirAmounts {
    float molecules = 0, aerosol = 0, ozone = 0;
};
inline AirAmounts operator+(AirAmounts a, AirAmounts b) {
    return {a.molecules + b.molecules, a.aerosol + b.aerosol, a.ozone + b.ozone};
}
inline AirAmounts operator*(float s, AirAmounts a) { return {s * a.molecules, s * a.aerosol, s * a.ozone}; }

class Atmosphere {
  public:
    static constexpr float kGroundRadius = 6371, kTopRadius = kGroundRadius + 80;  ///< [km]
    /// Of aerosol: asymmetry of Henyey and Greenstein's phase function, and albedo of single scattering.
    static constexpr float kAerosolG = 0.76f, kAerosolAlbedo = 0.94f;

    /// @param turbidity  optical depth of molecules and aerosol over that of molecules, at 550 nm; >= 1
    /// @param ozone      of the column [Dobson units]
    /// Cost: some 10 ms.
    Atmosphere(float turbidity, float ozone);

    /// Vertical optical depths.
    const SkySpectrum& MoleculesDepth() const { return molecules_; }
    const SkySpectrum& AerosolDepth() const { return aerosol_; }
    const SkySpectrum& OzoneDepth() const { return ozone_; }

    /// @param altitude  [km]
    AirAmounts DensityAt(float altitude) const;
    /// What lies between a point and space.
    /// @param radius  of the point [km], between the two above
    /// @param mu      cosine to the zenith, of a ray that does not meet the ground
    AirAmounts ColumnsToSpace(float radius, float mu) const;
    /// True if the ray meets the ground.
    static bool MeetsGround(float radius, float mu);
    /// exp(-optical depth).
    SkySpectrum Transmittance(AirAmounts columns) const;

  private:
    SkySpectrum molecules_, aerosol_, ozone_;
    std::vector<AirAmounts> columns_;  ///< [altitude][direction]
};

/// Phase function of molecules [1/sr], with the depolarisation of air [Chandrasekhar 1960; Bodhaine et al.
/// 1999].
float MoleculesPhase(float cosTheta);
/// Its Legendre moment of degree 2; those of other degrees but 0, which is 1, vanish.
float MoleculesPhaseMoment2();
/// Phase function of aerosol [1/sr] [Henyey and Greenstein 1941].
float AerosolPhase(float cosTheta);

}  // namespace lacquer
