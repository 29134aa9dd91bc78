// Sun, sky and ground of a clear day or of twilight, as light from all directions.
#pragma once

#include "pbrt/core/math.h"
#include "pbrt/core/spectrum.h"
#include "pbrt/scattering/sky_radiance.h"

namespace lacquer {

/// Toward the sun, with z up and +y in the north. Azimuths go clockwise for cameras that see pbrt's
/// left-handed space: east is -x. Angles in degrees.
Vec3 DirectionOfSun(float elevation, float azimuth);

/// The lowest sun [degrees]: the end of astronomical twilight.
inline constexpr float kLowestSun = -18;

struct ClearSkySettings {
    Vec3 sun{0, 0, 1};  ///< toward it, unit
    float turbidity = 3;
    float ozone = 300;  ///< [Dobson units]
    SkySpectrum groundAlbedo{};
    float scale = 1;
    bool hasSun = true, hasGround = true;  ///< without ground it is black below the horizon
};

/// Radiance from all directions, z up. 1 W m^-2 sr^-1 nm^-1 at all wavelengths has luminance 1 (times
/// `scale`), as of lights in scenes. The disk of the sun is there while its middle is over the horizon.
class ClearSky {
  public:
    /// Cost: that of SkyRadiance.
    explicit ClearSky(const ClearSkySettings& settings);

    SampledSpectrum Radiance(Vec3 w, const SampledWavelengths& lambda) const;

    /// Sky and ground, or the sun alone.
    enum class Part { Sky, Sun };
    /// With Y = 1 for luminance 1.
    XYZ ToXYZ(Vec3 w, Part part) const;

    Vec3 Sun() const { return settings_.sun; }
    bool HasDisk() const { return hasDisk_; }
    static float DiskSolidAngle();
    /// 1 - cosine of the angle between the middle and the rim of the disk.
    static float DiskHeight();
    bool IsInDisk(Vec3 w) const { return hasDisk_ && ChordToSun(w) <= 2 * DiskHeight(); }
    /// Within an angle [radians] of the disk.
    bool IsNearDisk(Vec3 w, float angle) const;

  private:
    /// Square of the distance on the unit sphere: cosines of small angles have few digits.
    float ChordToSun(Vec3 w) const { return LengthSquared(w - settings_.sun); }
    Vec3 ToSky(Vec3 w) const { return {side_.x * w.x + side_.y * w.y, side_.x * w.y - side_.y * w.x, w.z}; }
    XYZ ToXYZ(const SkySpectrum& transfer) const;

    ClearSkySettings settings_;
    SkyRadiance sky_;
    DenselySampledSpectrum sunlight_;                 ///< above the air
    std::array<XYZ, kNumSkyWavelengths> observer_{};  ///< weights of the sky's wavelengths, sunlight included
    Vec2 side_{1, 0};                                 ///< where the sun is, horizontally
    bool hasDisk_;
};

}  // namespace lacquer
