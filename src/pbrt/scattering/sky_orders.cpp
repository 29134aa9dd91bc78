#include "pbrt/scattering/sky_orders.h"

#include <cmath>

#include "pbrt/core/math.h"
#include "pbrt/core/parallel.h"
#include "pbrt/core/quadrature.h"

namespace lacquer::sky {
namespace {

constexpr float kFewAerosols = 1e-6f;    // columns in a step below which later orders leave them out
constexpr int kNumCosines = 6;           // of each hemisphere
constexpr int kNumAzimuths = 8;          // over half a turn
constexpr float kHighestNode = 60;       // [km]
constexpr float kReach = 12 * Pi / 180;  // how far the sun's angle changes along the longest rays

/// A point on a ray, as the air there sees it.
struct RayPoint {
    float altitude, sunZenith;
    float x, z;       ///< of the ray's direction: towards the sun's side, and to the zenith
    float sunCosine;  ///< of the angle between the ray and the direction to the sun
};

RayPoint PointOnRay(float radius, Vec3 sun, Vec3 w, float t) {
    const Vec3 p = Vec3(0, 0, radius) + t * w;
    const float r = Length(p);
    const Vec3 zenith = p / r;
    const float cosine = std::clamp(Dot(zenith, sun), -1.f, 1.f);
    const Vec3 side = sun - cosine * zenith;
    const float sine = Length(side);
    return {r - Atmosphere::kGroundRadius, ATan2(sine, cosine), sine > 1e-6f ? Dot(w, side) / sine : w.x,
            Dot(w, zenith), Dot(w, sun)};
}

Vec3 SunAt(float zenithAngle) { return {std::sin(zenithAngle), 0, std::cos(zenithAngle)}; }

/// Length of a ray until space or the ground [km].
float LengthOfRay(float radius, float mu, bool meetsGround) {
    const float limit = meetsGround ? Atmosphere::kGroundRadius : Atmosphere::kTopRadius;
    const float root = SafeSqrt(Sqr(radius) * (Sqr(mu) - 1) + Sqr(limit));
    return std::max(0.f, meetsGround ? -radius * mu - root : -radius * mu + root);
}

void AddScaled(float scale, const SkySpectrum& values, SkySpectrum* sum) {
    for (size_t i = 0; i < values.size(); ++i) (*sum)[i] += scale * values[i];
}

/// Directions of the whole sphere on one side of the sun's plane, with weights for both.
struct Quadrature {
    std::vector<Vec3> directions;
    std::vector<float> weights;
    Quadrature() {
        for (const QuadratureNode& node : GaussLegendre(kNumCosines))
            for (const int sign : {1, -1})
                for (int a = 0; a < kNumAzimuths; ++a) {
                    const auto z = float(sign * (0.5 + 0.5 * node.x));
                    const float phi = Pi * (float(a) + 0.5f) / kNumAzimuths, s = SafeSqrt(1 - z * z);
                    directions.emplace_back(s * std::cos(phi), s * std::sin(phi), z);
                    weights.push_back(float(0.5 * node.weight) * 2 * Pi / kNumAzimuths);
                }
    }
};

}  // namespace

std::array<float, kNumHarmonics> Harmonics(float x, float z) {
    // cos(m phi) sin^m(theta) by Chebyshev's recurrence in x, times derivatives of Legendre's polynomials.
    const float s2 = std::max(0.f, 1 - z * z), z2 = z * z;
    const float c1 = x, c2 = 2 * x * x - s2, c3 = x * (4 * x * x - 3 * s2);
    const float c4 = 8 * x * x * (x * x - s2) + s2 * s2;
    // sqrt((2 l + 1) / (4 pi)), and for m > 0 times sqrt(2 (l - m)! / (l + m)!).
    return {0.28209479f,
            0.48860251f * z,
            0.48860251f * c1,
            0.31539157f * (3 * z2 - 1),
            1.09254843f * z * c1,
            0.54627422f * c2,
            0.37317633f * z * (5 * z2 - 3),
            0.45704580f * (5 * z2 - 1) * c1,
            1.44530572f * z * c2,
            0.59004359f * c3,
            0.10578555f * (35 * z2 * z2 - 30 * z2 + 3),
            0.66904654f * z * (7 * z2 - 3) * c1,
            0.47308735f * (7 * z2 - 1) * c2,
            1.77013077f * z * c3,
            0.62583574f * c4};
}

namespace {
constexpr int kDegreeOf[kNumHarmonics] = {0, 1, 1, 2, 2, 2, 3, 3, 3, 3, 4, 4, 4, 4, 4};
}

Grid::Grid(float sunZenith)
    : first_(std::max(0.f, sunZenith - kReach)),
      step_((std::min(Pi, sunZenith + kReach) - first_) / (kNumAngles - 1)) {}

float Grid::Altitude(int i) const { return kHighestNode * Sqr(float(i) / (kNumAltitudes - 1)); }

Grid::Place Grid::PlaceOf(float altitude, float angle) const {
    const float row = std::sqrt(std::clamp(altitude / kHighestNode, 0.f, 1.f)) * (kNumAltitudes - 1);
    const float column = std::clamp((angle - first_) / step_, 0.f, float(kNumAngles - 1));
    const int r = std::min(int(row), kNumAltitudes - 2), c = std::min(int(column), kNumAngles - 2);
    const float dr = row - float(r), dc = column - float(c);
    const int node = r * kNumAngles + c;
    return {{node, node + 1, node + kNumAngles, node + kNumAngles + 1},
            {(1 - dr) * (1 - dc), (1 - dr) * dc, dr * (1 - dc), dr * dc}};
}

/// Calls visit(point, densities times the length of the step, transmittance to its middle) along a ray, and
/// ground(point, transmittance) where it ends on the ground.
template <class Visit, class Ground>
void Scattering::March(float altitude, float sunZenith, Vec3 w, const Visit& visit,
                       const Ground& ground) const {
    const float radius = Atmosphere::kGroundRadius + altitude;
    const Vec3 sun = SunAt(sunZenith);
    const bool meetsGround = Atmosphere::MeetsGround(radius, w.z);
    const float length = LengthOfRay(radius, w.z, meetsGround);
    AirAmounts columns;
    for (int i = 0; i < numSteps_; ++i) {
        const float u0 = float(i) / float(numSteps_), u1 = float(i + 1) / float(numSteps_);
        const float t0 = length * u0 * u0, t1 = length * u1 * u1;
        const RayPoint point = PointOnRay(radius, sun, w, 0.5f * (t0 + t1));
        const AirAmounts inStep = (t1 - t0) * air_.DensityAt(point.altitude);
        visit(point, inStep, air_.Transmittance(columns + 0.5f * inStep));
        columns = columns + inStep;
    }
    if (meetsGround) ground(PointOnRay(radius, sun, w, length), air_.Transmittance(columns));
}

SkySpectrum Scattering::DirectIrradiance(float sunZenith) const {
    const float mu = std::cos(sunZenith);
    if (mu <= 0) return {};
    SkySpectrum result = air_.Transmittance(air_.ColumnsToSpace(Atmosphere::kGroundRadius, mu));
    for (float& value : result) value *= mu;
    return result;
}

SkyRadiance::Parts Scattering::Single(float altitude, float sunZenith, Vec3 w) const {
    SkyRadiance::Parts parts;
    March(
        altitude, sunZenith, w,
        [&](const RayPoint& point, AirAmounts inStep, const SkySpectrum& transmittance) {
            const float radius = Atmosphere::kGroundRadius + std::max(point.altitude, 0.f);
            const float mu = std::cos(point.sunZenith);
            if (Atmosphere::MeetsGround(radius, mu)) return;
            const SkySpectrum sun = air_.Transmittance(air_.ColumnsToSpace(radius, mu));
            for (size_t i = 0; i < sun.size(); ++i) {
                const float light = transmittance[i] * sun[i];
                parts.molecules[i] += light * inStep.molecules * air_.MoleculesDepth()[i];
                parts.aerosol[i] +=
                    light * inStep.aerosol * air_.AerosolDepth()[i] * Atmosphere::kAerosolAlbedo;
            }
        },
        [&](const RayPoint& point, const SkySpectrum& transmittance) {
            const SkySpectrum irradiance = DirectIrradiance(point.sunZenith);
            for (size_t i = 0; i < irradiance.size(); ++i)
                parts.multiple[i] += transmittance[i] * groundAlbedo_[i] * InvPi * irradiance[i];
        });
    return parts;
}

SkySpectrum Scattering::Next(const Field& field, float altitude, float sunZenith, Vec3 w) const {
    SkySpectrum result{};
    std::array<float, kNumHarmonics> aerosolMoments{}, moleculesMoments{};
    for (size_t k = 0; k < kNumHarmonics; ++k) {
        const int degree = kDegreeOf[k];
        aerosolMoments[k] = Atmosphere::kAerosolAlbedo * std::pow(Atmosphere::kAerosolG, float(degree));
        moleculesMoments[k] = degree == 0 ? 1 : degree == 2 ? MoleculesPhaseMoment2() : 0;
    }
    March(
        altitude, sunZenith, w,
        [&](const RayPoint& point, AirAmounts inStep, const SkySpectrum& transmittance) {
            const Grid::Place place = grid_.PlaceOf(point.altitude, point.sunZenith);
            const std::array<float, kNumHarmonics> harmonics = Harmonics(point.x, point.z);
            const bool hasAerosol = inStep.aerosol > kFewAerosols;
            SkySpectrum molecules{}, aerosol{};
            for (int n = 0; n < 4; ++n) {
                const Moments& moments = field.moments[size_t(place.node[n])];
                for (size_t k = 0; k < kNumHarmonics; ++k) {
                    if (!hasAerosol && moleculesMoments[k] == 0) continue;
                    const float value = place.weight[n] * harmonics[k];
                    if (hasAerosol) AddScaled(value * aerosolMoments[k], moments[k], &aerosol);
                    if (moleculesMoments[k] > 0)
                        AddScaled(value * moleculesMoments[k], moments[k], &molecules);
                }
            }
            for (size_t i = 0; i < result.size(); ++i)
                result[i] += transmittance[i] * (inStep.molecules * air_.MoleculesDepth()[i] * molecules[i] +
                                                 inStep.aerosol * air_.AerosolDepth()[i] * aerosol[i]);
        },
        [&](const RayPoint& point, const SkySpectrum& transmittance) {
            const Grid::Place place = grid_.PlaceOf(0, point.sunZenith);
            for (int n = 0; n < 2; ++n)
                for (size_t i = 0; i < result.size(); ++i)
                    result[i] += place.weight[n] * transmittance[i] * groundAlbedo_[i] * InvPi *
                                 field.ground[size_t(place.node[n])][i];
        });
    return result;
}

/// The field of radianceAt(altitude, angle, direction).
template <class RadianceAt>
Field Scattering::Expand(const RadianceAt& radianceAt) const {
    static const Quadrature quadrature;
    Field field{std::vector<Moments>(size_t(Grid::kNumNodes)),
                std::vector<SkySpectrum>(size_t(Grid::kNumAngles))};
    ParallelFor(Grid::kNumNodes, [&](int64_t node) {
        const int row = int(node) / Grid::kNumAngles, column = int(node) % Grid::kNumAngles;
        Moments& moments = field.moments[size_t(node)];
        for (size_t d = 0; d < quadrature.directions.size(); ++d) {
            const Vec3 w = quadrature.directions[d];
            const SkySpectrum radiance = radianceAt(grid_.Altitude(row), grid_.Angle(column), w);
            const std::array<float, kNumHarmonics> harmonics = Harmonics(w.x, w.z);
            for (size_t k = 0; k < kNumHarmonics; ++k)
                AddScaled(quadrature.weights[d] * harmonics[k], radiance, &moments[k]);
            if (row == 0 && w.z > 0)
                AddScaled(quadrature.weights[d] * w.z, radiance, &field.ground[size_t(column)]);
        }
    });
    return field;
}

Field Scattering::First() const {
    return Expand([&](float altitude, float angle, Vec3 w) {
        SkyRadiance::Parts parts = Single(altitude, angle, w);
        const float cosine = Dot(w, SunAt(angle));
        AddScaled(MoleculesPhase(cosine), parts.molecules, &parts.multiple);
        AddScaled(AerosolPhase(cosine), parts.aerosol, &parts.multiple);
        return parts.multiple;
    });
}

Field Scattering::After(const Field& field) const {
    return Expand([&](float altitude, float angle, Vec3 w) { return Next(field, altitude, angle, w); });
}

}  // namespace lacquer::sky
