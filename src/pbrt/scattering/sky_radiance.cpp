#include "pbrt/scattering/sky_radiance.h"

#include <algorithm>
#include <cmath>

#include "pbrt/core/math.h"
#include "pbrt/core/parallel.h"
#include "pbrt/scattering/sky_orders.h"

namespace lacquer {
namespace {

constexpr int kNumElevations = 64, kNumAzimuths = 33;
constexpr int kMaxOrders = 40;
constexpr int kStepsOfOrders = 24, kStepsOfView = 128;
/// Of all irradiance of the ground: an order that adds less is the last one.
constexpr float kLastShare = 1e-3f;

/// Elevations lie closer together near the horizon.
float ElevationOf(int row) { return PiOver2 * Sqr(float(row) / (kNumElevations - 1)); }
float RowOf(float z) {
    return std::sqrt(std::asin(std::clamp(z, 0.f, 1.f)) * (2 * InvPi)) * (kNumElevations - 1);
}
Vec3 DirectionOf(int row, int column) {
    const float elevation = ElevationOf(row), azimuth = Pi * float(column) / (kNumAzimuths - 1);
    const float c = std::cos(elevation);
    return {c * std::cos(azimuth), c * std::sin(azimuth), std::sin(elevation)};
}

void Add(const sky::Field& field, sky::Field* sum) {
    for (size_t n = 0; n < field.moments.size(); ++n)
        for (size_t k = 0; k < field.moments[n].size(); ++k)
            for (size_t i = 0; i < field.moments[n][k].size(); ++i)
                sum->moments[n][k][i] += field.moments[n][k][i];
    for (size_t n = 0; n < field.ground.size(); ++n)
        for (size_t i = 0; i < field.ground[n].size(); ++i) sum->ground[n][i] += field.ground[n][i];
}

float Total(const std::vector<SkySpectrum>& spectra) {
    float sum = 0;
    for (const SkySpectrum& spectrum : spectra)
        for (const float value : spectrum) sum += value;
    return sum;
}

/// The fields of all orders together.
sky::Field AllOrders(const sky::Scattering& scattering) {
    sky::Field order = scattering.First(), sum = order;
    for (int i = 2; i < kMaxOrders && Total(order.ground) > kLastShare * Total(sum.ground); ++i) {
        order = scattering.After(order);
        Add(order, &sum);
    }
    return sum;
}

}  // namespace

SkyRadiance::SkyRadiance(const SkyOptions& options)
    : sun_(std::cos(options.sunElevation), 0, std::sin(options.sunElevation)),
      table_(size_t(kNumElevations) * kNumAzimuths) {
    const Atmosphere air(options.turbidity, options.ozone);
    const float zenith = PiOver2 - options.sunElevation;
    const sky::Grid grid(zenith);
    const sky::Field field = AllOrders(sky::Scattering(air, grid, options.groundAlbedo, kStepsOfOrders));
    const sky::Scattering scattering(air, grid, options.groundAlbedo, kStepsOfView);

    ParallelFor(kNumElevations, [&](int64_t row) {
        for (int column = 0; column < kNumAzimuths; ++column) {
            const Vec3 w = DirectionOf(int(row), column);
            Parts& parts = table_[size_t(row) * kNumAzimuths + size_t(column)];
            parts = scattering.Single(0, zenith, w);
            const SkySpectrum more = scattering.Next(field, 0, zenith, w);
            for (size_t i = 0; i < more.size(); ++i) parts.multiple[i] += more[i];
        }
    });

    if (sun_.z > 0)
        sunTransmittance_ = air.Transmittance(air.ColumnsToSpace(Atmosphere::kGroundRadius, sun_.z));
    const SkySpectrum direct = scattering.DirectIrradiance(zenith);
    const sky::Grid::Place place = grid.PlaceOf(0, zenith);
    for (size_t i = 0; i < ground_.size(); ++i) {
        float irradiance = direct[i];
        for (int n = 0; n < 2; ++n) irradiance += place.weight[n] * field.ground[size_t(place.node[n])][i];
        ground_[i] = options.groundAlbedo[i] * InvPi * irradiance;
    }
}

SkyRadiance::Place SkyRadiance::PlaceOf(Vec3 w) const {
    const float row = RowOf(w.z), azimuth = std::abs(std::atan2(w.y, w.x));
    const float column = std::min(azimuth * InvPi, 1.f) * (kNumAzimuths - 1);
    const int r = std::min(int(row), kNumElevations - 2), c = std::min(int(column), kNumAzimuths - 2);
    const float dr = row - float(r), dc = column - float(c);
    const size_t first = size_t(r) * kNumAzimuths + size_t(c);
    return {{first, first + 1, first + kNumAzimuths, first + kNumAzimuths + 1},
            {(1 - dr) * (1 - dc), (1 - dr) * dc, dr * (1 - dc), dr * dc}};
}

SkySpectrum SkyRadiance::Radiance(Vec3 w) const {
    const Place place = PlaceOf(w);
    const float cosine = Dot(w, sun_);
    const float molecules = MoleculesPhase(cosine), aerosol = AerosolPhase(cosine);
    SkySpectrum result{};
    for (int n = 0; n < 4; ++n) {
        const Parts& parts = table_[place.corner[n]];
        for (size_t i = 0; i < result.size(); ++i)
            result[i] += place.weight[n] *
                         (molecules * parts.molecules[i] + aerosol * parts.aerosol[i] + parts.multiple[i]);
    }
    return result;
}

namespace {
float At(const SkySpectrum& values, SkyBand band) {
    return Lerp(band.weight, values[band.index], values[band.index + 1]);
}
}  // namespace

SampledSpectrum SkyRadiance::Interpolate(const SkySpectrum& values, const SampledWavelengths& lambda) {
    SampledSpectrum result(0);
    for (int i = 0; i < kNumWavelengths; ++i) result.Set(i, At(values, SkyBandOf(lambda[i])));
    return result;
}

SampledSpectrum SkyRadiance::Radiance(Vec3 w, const SampledWavelengths& lambda) const {
    const Place place = PlaceOf(w);
    const float cosine = Dot(w, sun_);
    const float molecules = MoleculesPhase(cosine), aerosol = AerosolPhase(cosine);
    SampledSpectrum result(0);
    for (int i = 0; i < kNumWavelengths; ++i) {
        const SkyBand band = SkyBandOf(lambda[i]);
        float sum = 0;
        for (int n = 0; n < 4; ++n) {
            const Parts& parts = table_[place.corner[n]];
            sum += place.weight[n] * (molecules * At(parts.molecules, band) +
                                      aerosol * At(parts.aerosol, band) + At(parts.multiple, band));
        }
        result.Set(i, sum);
    }
    return result;
}

}  // namespace lacquer
