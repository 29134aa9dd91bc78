#include "pbrt/scattering/atmosphere.h"

#include <algorithm>
#include <cmath>

#include "pbrt/core/embedded.h"
#include "pbrt/core/math.h"
#include "pbrt/core/spectrum.h"

namespace lacquer {
namespace {

constexpr float kMoleculesScale = 8.4f, kAerosolScale = 1.2f;      // heights of exponential densities [km]
constexpr float kOzoneLow = 10, kOzonePeak = 25, kOzoneHigh = 40;  // a triangle [km]
constexpr float kDobsonUnit = 2.6867e20f;                          // molecules in a column of 1 m^2
constexpr float kAngstrom = 1.3f;                                  // aerosol's depth ~ lambda^-1.3
/// Depolarisation of air for unpolarised light, as the gamma of [Chandrasekhar 1960], rho / (2 - rho).
constexpr float kDepolarization = 0.0279f, kGamma = kDepolarization / (2 - kDepolarization);

constexpr int kNumAltitudes = 64, kNumDirections = 128, kNumSteps = 160;

/// Vertical optical depth of molecules at sea level [Bodhaine et al. 1999, eq. 30].
double RayleighDepth(double nanometers) {
    const double um2 = Sqr(1e-3 * nanometers), inverse = 1 / um2;
    return 0.0021520 * (1.0455996 - 341.29061 * inverse - 0.90230850 * um2) /
           (1 + 0.0027059889 * inverse - 85.968563 * um2);
}

/// The table of columns has more altitudes near the ground, and its directions by the length of the way,
/// which changes fastest at the horizon.
float AltitudeOf(float place) {
    return (Atmosphere::kTopRadius - Atmosphere::kGroundRadius) * place * place * place;
}
float PlaceOfAltitude(float altitude) {
    return std::cbrt(std::max(0.f, altitude) / (Atmosphere::kTopRadius - Atmosphere::kGroundRadius));
}
/// Lengths of the ways to space: straight up, and along the horizon.
struct Ways {
    float shortest, longest;
};
Ways WaysFrom(float radius) {
    const float ground2 = Sqr(Atmosphere::kGroundRadius);
    return {Atmosphere::kTopRadius - radius,
            SafeSqrt(Sqr(radius) - ground2) + std::sqrt(Sqr(Atmosphere::kTopRadius) - ground2)};
}
float WayToSpace(float radius, float mu) {
    return SafeSqrt(Sqr(radius) * (Sqr(mu) - 1) + Sqr(Atmosphere::kTopRadius)) - radius * mu;
}
float MuOfWay(float radius, float way) {
    if (!(way > 0)) return 1;
    return std::clamp((Sqr(Atmosphere::kTopRadius) - Sqr(radius) - Sqr(way)) / (2 * radius * way), -1.f, 1.f);
}

AirAmounts IntegrateToSpace(const Atmosphere& air, float radius, float mu) {
    const float way = WayToSpace(radius, mu);
    AirAmounts sum;
    for (int i = 0; i < kNumSteps; ++i) {
        // Steps grow along the way: the air is densest near its lower end.
        const float u0 = float(i) / kNumSteps, u1 = float(i + 1) / kNumSteps;
        const float t0 = way * u0 * u0, t1 = way * u1 * u1, t = 0.5f * (t0 + t1);
        const float r = std::sqrt(Sqr(radius) + Sqr(t) + 2 * radius * t * mu);
        sum = sum + (t1 - t0) * air.DensityAt(r - Atmosphere::kGroundRadius);
    }
    return sum;
}

}  // namespace

Atmosphere::Atmosphere(float turbidity, float ozone) : columns_(size_t(kNumAltitudes) * kNumDirections) {
    std::vector<float> nm, crossSection;
    for (const std::vector<double>& row : EmbeddedTable("spectra/sky/ozone.txt")) {
        nm.push_back(float(row.at(0)));
        crossSection.push_back(float(row.at(1) * 1e25));  // [1e-25 m^2], so that floats hold it
    }
    const auto ozoneSpectrum = PiecewiseLinearSpectrum::Extended(std::move(nm), std::move(crossSection));
    const double aerosolAt550 = (double(turbidity) - 1) * RayleighDepth(550);
    for (int i = 0; i < kNumSkyWavelengths; ++i) {
        const float lambda = SkyWavelength(i);
        molecules_[size_t(i)] = float(RayleighDepth(double(lambda)));
        aerosol_[size_t(i)] = float(aerosolAt550) * std::pow(lambda / 550, -kAngstrom);
        ozone_[size_t(i)] = ozone * kDobsonUnit * 1e-25f * ozoneSpectrum.Evaluate(lambda);
    }
    for (int a = 0; a < kNumAltitudes; ++a) {
        const float radius = kGroundRadius + AltitudeOf(float(a) / (kNumAltitudes - 1));
        const Ways ways = WaysFrom(radius);
        for (int d = 0; d < kNumDirections; ++d) {
            const float way = Lerp(float(d) / (kNumDirections - 1), ways.shortest, ways.longest);
            columns_[size_t(a) * kNumDirections + size_t(d)] =
                IntegrateToSpace(*this, radius, MuOfWay(radius, way));
        }
    }
}

AirAmounts Atmosphere::DensityAt(float altitude) const {
    altitude = std::max(altitude, 0.f);
    const float rise = (altitude - kOzoneLow) / (kOzonePeak - kOzoneLow);
    const float fall = (kOzoneHigh - altitude) / (kOzoneHigh - kOzonePeak);
    return {Exp(-altitude / kMoleculesScale) / kMoleculesScale,
            Exp(-altitude / kAerosolScale) / kAerosolScale,
            std::max(0.f, std::min(rise, fall)) * 2 / (kOzoneHigh - kOzoneLow)};
}

bool Atmosphere::MeetsGround(float radius, float mu) {
    return mu < 0 && Sqr(radius) * (1 - Sqr(mu)) < Sqr(kGroundRadius);
}

AirAmounts Atmosphere::ColumnsToSpace(float radius, float mu) const {
    const Ways ways = WaysFrom(radius);
    const float x = (WayToSpace(radius, mu) - ways.shortest) / std::max(ways.longest - ways.shortest, 1e-3f);
    const float column = std::clamp(x, 0.f, 1.f) * (kNumDirections - 1);
    const float row = std::clamp(PlaceOfAltitude(radius - kGroundRadius), 0.f, 1.f) * (kNumAltitudes - 1);
    const int c = std::min(int(column), kNumDirections - 2), r = std::min(int(row), kNumAltitudes - 2);
    const float dc = column - float(c), dr = row - float(r);
    const auto at = [&](int i, int j) { return columns_[size_t(r + i) * kNumDirections + size_t(c + j)]; };
    return (1 - dr) * ((1 - dc) * at(0, 0) + dc * at(0, 1)) + dr * ((1 - dc) * at(1, 0) + dc * at(1, 1));
}

SkySpectrum Atmosphere::Transmittance(AirAmounts columns) const {
    SkySpectrum result;
    for (size_t i = 0; i < result.size(); ++i)
        result[i] = Exp(
            -(molecules_[i] * columns.molecules + aerosol_[i] * columns.aerosol + ozone_[i] * columns.ozone));
    return result;
}

float MoleculesPhase(float cosTheta) {
    return 3 / (16 * Pi * (1 + 2 * kGamma)) * ((1 + 3 * kGamma) + (1 - kGamma) * Sqr(cosTheta));
}
float MoleculesPhaseMoment2() { return (1 - kGamma) / (10 * (1 + 2 * kGamma)); }
float AerosolPhase(float cosTheta) {
    constexpr float g = Atmosphere::kAerosolG;
    const float d = 1 + g * g - 2 * g * cosTheta;
    return Inv4Pi * (1 - g * g) / (d * std::sqrt(d));
}

}  // namespace lacquer
