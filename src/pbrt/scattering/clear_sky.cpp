#include "pbrt/scattering/clear_sky.h"

#include <algorithm>
#include <cmath>

#include "pbrt/core/embedded.h"

namespace lacquer {
namespace {

constexpr float kSunRadius = 0.2666f * Pi / 180;  // mean angle from its centre to its rim

/// Sunlight above the air [W m^-2 nm^-1], in the unit of lights.
DenselySampledSpectrum Sunlight(float scale) {
    std::vector<float> nm, irradiance;
    for (const std::vector<double>& row : EmbeddedTable("spectra/sky/sun.txt")) {
        nm.push_back(float(row.at(0)));
        irradiance.push_back(scale / kCieYIntegral * float(row.at(1)));
    }
    return DenselySampledSpectrum(PiecewiseLinearSpectrum::Extended(std::move(nm), std::move(irradiance)));
}

/// Of each wavelength of the sky: integrals of the observer times sunlight times the hat between its
/// neighbours, so that a spectrum's integral is a sum over the wavelengths.
std::array<XYZ, kNumSkyWavelengths> ObserverWeights(const DenselySampledSpectrum& sunlight) {
    std::array<XYZ, kNumSkyWavelengths> weights{};
    for (int nm = 360; nm <= 830; ++nm) {
        const auto lambda = float(nm);
        const SkyBand band = SkyBandOf(lambda);
        const XYZ value = sunlight.Evaluate(lambda) *
                          XYZ(CieX().Evaluate(lambda), CieY().Evaluate(lambda), CieZ().Evaluate(lambda));
        weights[band.index] += (1 - band.weight) * value;
        weights[band.index + 1] += band.weight * value;
    }
    return weights;
}

SkyOptions OptionsOf(const ClearSkySettings& settings) {
    return {.turbidity = settings.turbidity,
            .ozone = settings.ozone,
            .sunElevation = std::asin(std::clamp(settings.sun.z, -1.f, 1.f)),
            .groundAlbedo = settings.groundAlbedo};
}

}  // namespace

Vec3 DirectionOfSun(float elevation, float azimuth) {
    const float e = elevation * Pi / 180, a = azimuth * Pi / 180;
    return {-std::cos(e) * std::sin(a), std::cos(e) * std::cos(a), std::sin(e)};
}

ClearSky::ClearSky(const ClearSkySettings& settings)
    : settings_(settings),
      sky_(OptionsOf(settings)),
      sunlight_(Sunlight(settings.scale)),
      observer_(ObserverWeights(sunlight_)),
      hasDisk_(settings.hasSun && settings.sun.z > 0) {
    const float horizontal = std::hypot(settings.sun.x, settings.sun.y);
    if (horizontal > 0) side_ = Vec2(settings.sun.x, settings.sun.y) / horizontal;
}

float ClearSky::DiskHeight() { return 2 * Sqr(std::sin(kSunRadius / 2)); }
float ClearSky::DiskSolidAngle() { return 2 * Pi * DiskHeight(); }
bool ClearSky::IsNearDisk(Vec3 w, float angle) const {
    return hasDisk_ && ChordToSun(w) <= Sqr(kSunRadius + angle);
}

SampledSpectrum ClearSky::Radiance(Vec3 w, const SampledWavelengths& lambda) const {
    SampledSpectrum transfer(0);
    if (w.z >= 0)
        transfer = sky_.Radiance(ToSky(w), lambda);
    else if (settings_.hasGround)
        transfer = SkyRadiance::Interpolate(sky_.Ground(), lambda);
    if (w.z >= 0 && IsInDisk(w))
        transfer += SkyRadiance::Interpolate(sky_.SunTransmittance(), lambda) / DiskSolidAngle();
    return transfer * sunlight_.Sample(lambda);
}

XYZ ClearSky::ToXYZ(const SkySpectrum& transfer) const {
    XYZ sum(0);
    for (size_t i = 0; i < transfer.size(); ++i) sum += transfer[i] * observer_[i];
    return sum;
}

XYZ ClearSky::ToXYZ(Vec3 w, Part part) const {
    if (part == Part::Sun)
        return w.z >= 0 && IsInDisk(w) ? ToXYZ(sky_.SunTransmittance()) / DiskSolidAngle() : XYZ(0);
    if (w.z >= 0) return ToXYZ(sky_.Radiance(ToSky(w)));
    return settings_.hasGround ? ToXYZ(sky_.Ground()) : XYZ(0);
}

}  // namespace lacquer
