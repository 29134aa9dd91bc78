#include "bulk/table/bulk_computation.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "bulk/ensembles/structure.h"
#include "bulk/table/ball_inversion.h"
#include "bulk/table/bulk_problem.h"
#include "pbrt/core/check.h"
#include "pbrt/core/error.h"
#include "pbrt/core/parallel.h"

namespace lacquer::bulk {
namespace {

constexpr int kTasksPerThread = 4;

/// Of a p that is linear in the cosine between nodes.
double MeanCosineOf(const std::vector<double>& anglesDeg, const std::vector<double>& phase) {
    double sum = 0;
    for (size_t i = 0; i + 1 < phase.size(); ++i) {
        const double a = std::cos(anglesDeg[i] * std::numbers::pi / 180),
                     b = std::cos(anglesDeg[i + 1] * std::numbers::pi / 180);
        // The integral of a product of two linear functions.
        sum += 2 * std::numbers::pi * (a - b) *
               (a * (2 * phase[i] + phase[i + 1]) + b * (phase[i] + 2 * phase[i + 1])) / 6;
    }
    return sum / NormOfPhase(anglesDeg, phase);
}

}  // namespace

BulkComputation::BulkComputation(BulkSettings settings)
    : EnsembleComputation(std::move(settings), kTasksPerThread) {
    numAngles_ = NumAnglesOf(Settings(), GetEnsemble());
    const std::vector<double> thetas = EvenAngles(numAngles_ - 1);
    for (const double wavelength : Settings().wavelengths) {
        sums_.emplace_back(numAngles_);
        if (Settings().method == BulkMethod::Clusters)
            harmonics_.emplace_back(DegreesAt(Settings(), GetEnsemble(), wavelength).farField, thetas);
    }
}

std::unique_ptr<Solution> BulkComputation::Solve(std::vector<Sphere> spheres,
                                                 const RealizationSettings& settings, size_t wavelength,
                                                 Observer* observer) const {
    auto solved = std::make_unique<SolvedRealization>(
        SolveRealization(std::move(spheres), settings, harmonics_[wavelength]));
    if (observer) observer->Advance(1);
    return solved;
}

void BulkComputation::Add(const Solution& solution, size_t wavelength) {
    sums_[wavelength].Add(static_cast<const SolvedRealization&>(solution).scattering);
}

ConvergencePoint BulkComputation::MeansAt(size_t wavelength) const {
    const ScatteringAverage average = AverageAt(wavelength);
    return {NumRealizations(), average.extinction, average.scattering, average.g};
}

// For each particle: integrals over the distributions of radii of all species by their shares in the number.
ScatteringAverage BulkComputation::WithoutClusters(size_t wavelength, BulkMethod method) const {
    LACQUER_CHECK(method != BulkMethod::Clusters);
    const double k = Wavenumber(wavelength);
    double cubes = 0;
    ScatteringAverage average;
    average.intensity.assign(size_t(numAngles_), 0.);
    average.intensityError = average.intensity;
    for (size_t s = 0; s < Settings().indices.size(); ++s) {
        const Species& species = Settings().ensemble.species[s];
        const Complex m = Settings().indices[s].At(Settings().wavelengths[wavelength]) / Settings().hostIndex;
        cubes += GetEnsemble().NumberShare(int(s)) * species.radius.Moment(3);
        for (const RadiusDistribution::Node& node : species.radius.Nodes()) {
            const double x = k * node.radius, share = GetEnsemble().NumberShare(int(s)) * node.weight;
            const MieCoefficients mie = MieOfSphere(x, m, MieDegree(x));
            const MieEfficiencies q = EfficienciesOf(mie, x);
            const double area = std::numbers::pi * x * x * share;
            average.extinction.mean += area * q.extinction;
            average.absorption.mean += m.imag() == 0 ? 0 : area * q.Absorption();
            for (int i = 0; i < numAngles_; ++i)
                average.intensity[size_t(i)] +=
                    share * AmplitudesAt(mie, std::cos(i * std::numbers::pi / (numAngles_ - 1))).Intensity();
        }
    }
    const double fraction = VolumeFractionOf(Settings().ensemble);
    // Of mixtures and distributions: as if all had the radius of the mean volume.
    const double diameter = 2 * k * std::cbrt(cubes);
    const std::vector<double> weights = ClenshawCurtisWeights(numAngles_ - 1);
    double cosines = 0;
    for (int i = 0; i < numAngles_; ++i) {
        const double theta = i * std::numbers::pi / (numAngles_ - 1);
        double& intensity = average.intensity[size_t(i)];
        if (method == BulkMethod::Structure)
            intensity *= PercusYevickStructureFactor(fraction, 2 * std::sin(theta / 2) * diameter);
        const double part = 2 * std::numbers::pi * weights[size_t(i)] * intensity;
        average.scattering.mean += part;
        cosines += part * std::cos(theta);
    }
    average.g.mean = cosines / average.scattering.mean;
    return average;
}

// Differences of estimates are negative at times, or nothing but rounding where all realisations are alike.
void BulkComputation::RequireScattering(const ScatteringAverage& average, size_t wavelength) const {
    constexpr double kRounding = 1e-12;
    double total = 0;
    if (Settings().method == BulkMethod::Clusters)
        total = AverageAt(wavelength, AverageMode::Aggregate).scattering.mean;
    if (average.scattering.mean > kRounding * total) return;
    throw SceneError(
        {}, fmt::format("the average \"{}\" of {} realisations leaves no scattering at {:g} nm; "
                        "expected more realisations, and some that differ",
                        ModeName(Settings().mode), NumRealizations(), Settings().wavelengths[wavelength]));
}

BulkRow BulkComputation::RowAt(size_t w) const {
    const bool hasClusters = Settings().method == BulkMethod::Clusters;
    const ScatteringAverage average = hasClusters ? AverageAt(w) : WithoutClusters(w, Settings().method);
    RequireScattering(average, w);
    const double perMillimetre = CoefficientOfUnit(Settings(), GetEnsemble(), Settings().wavelengths[w]);
    const auto scaled = [&](const ScatteringAverage::Value& value) {
        return ScatteringAverage::Value{value.mean * perMillimetre, value.error * perMillimetre};
    };
    BulkRow row{scaled(average.scattering), scaled(average.absorption), average.g, average.intensity, 0, {}};
    // Nothing but rounding where hardly anything is absorbed, of either sign.
    row.sigmaA.mean = std::max(0., row.sigmaA.mean);
    row.g.mean = std::clamp(row.g.mean, -1., 1.);
    // Differences of estimates may be negative where there is hardly any light.
    for (double& value : row.phase) value = std::max(0., value);
    const std::vector<double> angles = AnglesDeg();
    const double norm = NormOfPhase(angles, row.phase);
    for (double& value : row.phase) value /= norm;
    if (!hasClusters) return row;
    row.errorPhase = NormOfPhase(angles, average.intensityError) / norm;
    for (const auto& elements : average.mueller)
        row.mueller.insert(row.mueller.end(), elements.begin(), elements.end());
    if (Settings().removesMultipleScattering) RemoveMultipleScattering(w, &row);
    return row;
}

void BulkComputation::RemoveMultipleScattering(size_t wavelength, BulkRow* row) const {
    constexpr double kMillimetresInMicrometre = 1e-3;
    // Particles of a ball that was cut reach farther than their centres, which its volume counts.
    double cubes = 0;
    for (size_t s = 0; s < Settings().ensemble.species.size(); ++s)
        cubes += GetEnsemble().NumberShare(int(s)) * Settings().ensemble.species[s].radius.Moment(3);
    const double radius = GetEnsemble().BallRadius();
    const bool isCut = Settings().ensemble.arrangement == Arrangement::Cut;
    const double reach = radius + (isCut ? std::cbrt(cubes) : 0), ratio = radius / reach;
    // Cross section over that of the ball, of a coefficient; and back, by the thickness across the middle.
    const double share = 4. / 3 * radius * ratio * ratio * kMillimetresInMicrometre;
    const double coefficient = 1 / (2 * reach * std::pow(ratio, 3) * kMillimetresInMicrometre);
    const auto times = [](const ScatteringAverage::Value& value, double factor) {
        return ScatteringAverage::Value{factor * value.mean, factor * value.error};
    };
    const BallLosses losses{times(row->sigmaS, share), times(row->sigmaA, share)};
    if (losses.Sum() > kLargestLostShare)
        throw SceneError(
            {},
            fmt::format("at {:g} nm balls of {} particles let too little light through to tell "
                        "what is in them: {:.3g} % is lost; expected fewer particles",
                        Settings().wavelengths[wavelength], Settings().ensemble.count, 100 * losses.Sum()));
    const std::vector<double> angles = AnglesDeg();
    MediumOfBall medium = InvertBall(losses, angles, row->phase);
    row->sigmaS = times(medium.scattering, coefficient);
    row->sigmaA = times(medium.absorption, coefficient);
    row->phase = std::move(medium.phase);
    // As if all of what leaves after several events were known.
    row->errorPhase /= medium.single;
    row->g = {MeanCosineOf(angles, row->phase), row->g.error / medium.single};
    row->mueller.clear();  // is that of the ball
}

std::vector<double> BulkComputation::AnglesDeg() const {
    std::vector<double> angles;
    for (int i = 0; i < numAngles_; ++i) angles.push_back(i * 180. / (numAngles_ - 1));
    return angles;
}

std::vector<BulkRow> BulkComputation::Rows() const {
    std::vector<BulkRow> rows(Settings().wavelengths.size());
    ParallelFor(int64_t(rows.size()), [&](int64_t w) { rows[size_t(w)] = RowAt(size_t(w)); });
    return rows;
}

BulkTable BulkComputation::TableOf(std::vector<BulkRow> rows) const {
    BulkTable table;
    switch (Settings().method) {
        case BulkMethod::Independent:
            table.mode = "independent";
            break;
        case BulkMethod::Structure:
            table.mode = "structure";
            break;
        case BulkMethod::Clusters:
            table.mode = ModeName(Settings().mode);
    }
    table.hostIndex = Settings().hostIndex;
    table.wavelengths = Settings().wavelengths;
    table.angles = AnglesDeg();
    for (BulkRow& row : rows) {
        table.sigmaS.push_back(row.sigmaS.mean);
        table.sigmaA.push_back(row.sigmaA.mean);
        table.g.push_back(row.g.mean);
        table.phase.push_back(std::move(row.phase));
        if (Settings().method != BulkMethod::Clusters) continue;
        table.errorSigmaS.push_back(row.sigmaS.error);
        table.errorSigmaA.push_back(row.sigmaA.error);
        table.errorPhase.push_back(row.errorPhase);
        if (!row.mueller.empty()) table.mueller.push_back(std::move(row.mueller));
    }
    return table;
}

}  // namespace lacquer::bulk
