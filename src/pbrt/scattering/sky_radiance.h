// The light of a clear sky: sunlight that an atmosphere has scattered once and more often.
#pragma once

#include <vector>

#include "pbrt/core/vec.h"
#include "pbrt/scattering/atmosphere.h"

namespace lacquer {

struct SkyOptions {
    float turbidity = 3;     ///< of Atmosphere, 1 to 10
    float ozone = 300;       ///< [Dobson units]
    float sunElevation = 0;  ///< angle of the sun over the horizon [radians]; below it there is twilight
    SkySpectrum groundAlbedo{};
};

/// A cloudless sky as seen from the ground, for sunlight of irradiance 1 at all wavelengths. z is up, the sun
/// is over the direction +x.
///
/// Light that was scattered once is integrated along each direction. What was scattered more often follows by
/// successive orders [Chandrasekhar 1960; Bruneton and Neyret 2008]: at points of a grid over altitude and
/// the sun's angle, radiance is expanded in spherical harmonics of degree 4, which the phase functions
/// multiply by their moments. The share of orders that are left out is below 0.1 %.
class SkyRadiance {
  public:
    /// Cost: about a second of one core, in parallel.
    explicit SkyRadiance(const SkyOptions& options);

    /// What comes down one direction, but for the phase functions of light that was scattered once: they
    /// change fast near the sun.
    struct Parts {
        SkySpectrum molecules{}, aerosol{};  ///< times the phase functions
        SkySpectrum multiple{};              ///< scattered more often, or by the ground before
    };
    /// Radiance [1/sr] of the sky at a direction, which has w.z >= 0.
    SkySpectrum Radiance(Vec3 w) const;
    SampledSpectrum Radiance(Vec3 w, const SampledWavelengths& lambda) const;
    /// Linear between the sky's wavelengths.
    static SampledSpectrum Interpolate(const SkySpectrum& values, const SampledWavelengths& lambda);
    /// Radiance of the ground, in all directions w.z < 0.
    const SkySpectrum& Ground() const { return ground_; }
    /// What the air leaves of sunlight, on its way to the ground: zero below the horizon.
    const SkySpectrum& SunTransmittance() const { return sunTransmittance_; }
    Vec3 SunDirection() const { return sun_; }

  private:
    struct Place {
        size_t corner[4];
        float weight[4];
    };
    Place PlaceOf(Vec3 w) const;

    Vec3 sun_;
    SkySpectrum ground_{}, sunTransmittance_{};
    std::vector<Parts> table_;  ///< [elevation][azimuth from the sun]
};

}  // namespace lacquer
