// Successive orders of scattering in an atmosphere with the sun at one angle.
#pragma once

#include <vector>

#include "pbrt/core/vec.h"
#include "pbrt/scattering/sky_radiance.h"

namespace lacquer::sky {

/// Spherical harmonics of degrees 0 to 4, even in the azimuth from the sun: 15 of them.
inline constexpr int kMaxDegree = 4, kNumHarmonics = (kMaxDegree + 1) * (kMaxDegree + 2) / 2;
/// A function of direction for each wavelength.
using Moments = std::array<SkySpectrum, kNumHarmonics>;
/// Values at a direction whose cosine to the zenith is `z`, and to the horizontal towards the sun `x`.
std::array<float, kNumHarmonics> Harmonics(float x, float z);

/// The grid: altitudes times angles between zenith and sun, for points as far as one can see.
class Grid {
  public:
    static constexpr int kNumAltitudes = 12, kNumAngles = 9;
    static constexpr int kNumNodes = kNumAltitudes * kNumAngles;
    /// @param sunZenith  of the observer [radians]
    explicit Grid(float sunZenith);
    float Altitude(int i) const;  ///< [km]
    float Angle(int j) const { return first_ + float(j) * step_; }

    /// The nodes around a point, with weights that add up to 1.
    struct Place {
        int node[4];
        float weight[4];
    };
    Place PlaceOf(float altitude, float angle) const;

  private:
    float first_, step_;
};

/// What has been scattered at least once, at all nodes.
struct Field {
    std::vector<Moments> moments;     ///< of radiance
    std::vector<SkySpectrum> ground;  ///< irradiance of the ground, for each angle
};

/// Light at a point, for the integrals along rays.
class Scattering {
  public:
    /// @param numSteps  along a ray: long ones along the horizon need many
    Scattering(const Atmosphere& air, const Grid& grid, const SkySpectrum& groundAlbedo, int numSteps)
        : air_(air), grid_(grid), groundAlbedo_(groundAlbedo), numSteps_(numSteps) {}

    /// Sunlight that was scattered once on a ray from an altitude [km] under the sun's angle `sunZenith`, and
    /// that the ground sent straight back.
    SkyRadiance::Parts Single(float altitude, float sunZenith, Vec3 w) const;
    /// Light of `field` that was scattered once more, or reflected by the ground.
    SkySpectrum Next(const Field& field, float altitude, float sunZenith, Vec3 w) const;

    /// Fields of the first order, and of the one after `field`.
    Field First() const;
    Field After(const Field& field) const;
    /// Irradiance of the ground by sunlight itself.
    SkySpectrum DirectIrradiance(float sunZenith) const;

  private:
    template <class Visit, class Ground>
    void March(float altitude, float sunZenith, Vec3 w, const Visit& visit, const Ground& ground) const;
    template <class RadianceAt>
    Field Expand(const RadianceAt& radianceAt) const;

    const Atmosphere& air_;
    const Grid& grid_;
    const SkySpectrum& groundAlbedo_;
    int numSteps_;
};

}  // namespace lacquer::sky
