#include "bulk/table/oriented_computation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bulk/table/bulk_problem.h"
#include "pbrt/core/check.h"
#include "pbrt/core/error.h"
#include "pbrt/scattering/oriented_table.h"

namespace lacquer::bulk {
namespace {

/// Of solutions for all incidences, which take long.
constexpr int kOrientedTasksPerThread = 2;
/// Integrals of a row that differ from its coefficients by more, relatively, are no rounding.
constexpr double kUnbalanced = 1e-5;

BulkSettings OrientedOnes(BulkSettings settings) {
    settings.ensemble.isOriented = true;
    return settings;
}

std::vector<double> AnglesDeg(const OrientedSettings& settings) {
    std::vector<double> angles;
    const int steps = 2 * (settings.numIncidences - 1);
    for (int j = 0; j <= steps; ++j) angles.push_back(180. * j / steps);
    return angles;
}

/// The mean over incidences of the integrals of values times the cosine between directions.
double MeanCosine(const OrientedGrid& grid, std::span<const double> angles, std::span<const double> values) {
    std::vector<double> weighted(values.begin(), values.end()), means;
    constexpr double kRadians = std::numbers::pi / 180;
    for (size_t i = 0; i < grid.NumIncidences(); ++i) {
        const double a = angles[i] * kRadians;
        for (size_t j = 0; j < grid.NumAngles(); ++j) {
            const double b = angles[j] * kRadians;
            for (size_t k = 0; k < grid.NumAzimuths(); ++k) {
                const double phi = double(k) * std::numbers::pi / double(grid.NumAzimuths() - 1);
                weighted[grid.Index(i, j) + k] *=
                    std::cos(a) * std::cos(b) + std::sin(a) * std::sin(b) * std::cos(phi);
            }
        }
        means.push_back(grid.OverSphere<double>(weighted, i));
    }
    return grid.MeanOverIncidences(means);
}

/// Of the mean of all groups, from values without one group each [Efron 1979].
double JackknifeError(const std::vector<double>& without) {
    const double count = double(without.size());
    double mean = 0, squares = 0;
    for (const double value : without) mean += value / count;
    for (const double value : without) squares += (value - mean) * (value - mean) / count;
    return std::sqrt(squares * (count - 1));
}

}  // namespace

OrientedComputation::OrientedComputation(BulkSettings settings, const OrientedSettings& oriented)
    : EnsembleComputation(OrientedOnes(std::move(settings)), kOrientedTasksPerThread), oriented_(oriented) {
    LACQUER_CHECK(Settings().method == BulkMethod::Clusters);
    directions_.reserve(Settings().wavelengths.size());  // sums refer to them
    for (const double wavelength : Settings().wavelengths) {
        const int degree = DegreesAt(Settings(), GetEnsemble(), wavelength).farField;
        directions_.emplace_back(oriented_.numIncidences, oriented_.numAzimuths, degree);
        sums_.emplace_back(directions_.back());
    }
}

int OrientedComputation::BatchSizeFor(size_t numWavelengths) {
    return EnsembleComputation::BatchSizeFor(numWavelengths, kOrientedTasksPerThread);
}

int64_t OrientedComputation::UnitsPerRealization() const {
    return EnsembleComputation::UnitsPerRealization() * oriented_.numIncidences;
}

std::unique_ptr<Solution> OrientedComputation::Solve(std::vector<Sphere> spheres,
                                                     const RealizationSettings& settings, size_t wavelength,
                                                     Observer* observer) const {
    auto solved = std::make_unique<OrientedRealization>(
        SolveOriented(std::move(spheres), settings, directions_[wavelength], observer));
    if (solved->wasStopped) return nullptr;
    return solved;
}

void OrientedComputation::Add(const Solution& solution, size_t wavelength) {
    sums_[wavelength].Add(static_cast<const OrientedRealization&>(solution));
}

OrientedMeans OrientedComputation::WeightedMeans(size_t wavelength,
                                                 const std::vector<double>& weights) const {
    struct Cross {
        double extinction = 0, scattering = 0, absorption = 0, asymmetry = 0;
    };
    const auto sum = [&](const OrientedAverage& average) {
        Cross mean;
        for (size_t i = 0; i < weights.size(); ++i) {
            const OrientedAverage::Incidence& found = average.incidences[i];
            mean.extinction += weights[i] * found.extinction;
            mean.scattering += weights[i] * found.scattering;
            mean.absorption += weights[i] * found.absorption;
            mean.asymmetry += weights[i] * found.asymmetry;
        }
        return mean;
    };
    const AverageMode mode = Settings().mode;
    const Cross all = sum(sums_[wavelength].CrossSections(mode));
    std::vector<Cross> without;
    for (const OrientedAverage& average : sums_[wavelength].CrossSectionsWithoutGroups(mode))
        without.push_back(sum(average));
    const auto valueOf = [&](auto&& quantity) {
        std::vector<double> values;
        for (const Cross& each : without) values.push_back(quantity(each));
        return ScatteringAverage::Value{quantity(all), values.empty() ? 0 : JackknifeError(values)};
    };
    const auto over = [](double part, double whole) { return whole != 0 ? part / whole : 0; };
    return {
        .extinction = valueOf([](const Cross& c) { return c.extinction; }),
        .scattering = valueOf([](const Cross& c) { return c.scattering; }),
        .absorption = valueOf([](const Cross& c) { return c.absorption; }),
        .sum = valueOf([](const Cross& c) { return c.scattering + c.absorption; }),
        .albedo = valueOf([&](const Cross& c) { return over(c.scattering, c.scattering + c.absorption); }),
        .g = valueOf([&](const Cross& c) { return over(c.asymmetry, c.scattering); })};
}

std::vector<OrientedMeans> OrientedComputation::MeansOfIncidences(size_t wavelength) const {
    std::vector<OrientedMeans> means;
    std::vector<double> weights(size_t(oriented_.numIncidences), 0.);
    for (double& weight : weights) {
        weight = 1;
        means.push_back(WeightedMeans(wavelength, weights));
        weight = 0;
    }
    return means;
}

OrientedMeans OrientedComputation::MeansOverIncidences(size_t wavelength) const {
    const OrientedGrid grid(AnglesDeg(oriented_), oriented_.numAzimuths);
    std::vector<double> weights, one(size_t(oriented_.numIncidences), 0.);
    for (double& incidence : one) {
        incidence = 1;
        weights.push_back(grid.MeanOverIncidences(one));
        incidence = 0;
    }
    return WeightedMeans(wavelength, weights);
}

ConvergencePoint OrientedComputation::MeansAt(size_t wavelength) const {
    const OrientedMeans means = MeansOverIncidences(wavelength);
    return {NumRealizations(), means.extinction, means.scattering, means.g};
}

/// A wavelength of the table, per millimetre.
struct OrientedComputation::Row {
    std::vector<double> sigmaS, sigmaA, scattered;
    double reciprocityError = 0;
};

OrientedComputation::Row OrientedComputation::RowOf(const OrientedAverage& average, size_t wavelength) const {
    const double perMillimetre =
        CoefficientOfUnit(Settings(), GetEnsemble(), Settings().wavelengths[wavelength]);
    Row row;
    for (const OrientedAverage::Incidence& found : average.incidences) {
        if (!(found.scattering > 0))
            throw SceneError(
                {}, fmt::format("the average \"{}\" of {} realisations leaves no scattering at {:g} nm "
                                "in some direction; expected more realisations, and some that differ",
                                ModeName(Settings().mode), NumRealizations(),
                                Settings().wavelengths[wavelength]));
        row.sigmaS.push_back(found.scattering * perMillimetre);
        // Nothing but rounding where hardly anything is absorbed, of either sign.
        row.sigmaA.push_back(std::max(0., found.absorption) * perMillimetre);
        // Differences of estimates may be negative where there is hardly any light.
        for (const double value : found.intensity)
            row.scattered.push_back(std::max(0., value) * perMillimetre);
    }
    const OrientedGrid grid(AnglesDeg(oriented_), oriented_.numAzimuths);
    row.reciprocityError = MakeReciprocal(grid, row.sigmaS, row.scattered);
    // A peak that is narrower than the steps of the grid may not be there at all.
    for (size_t i = 0; i < grid.NumIncidences(); ++i)
        if (!(std::abs(grid.OverSphere<double>(row.scattered, i) / row.sigmaS[i] - 1) < kUnbalanced))
            throw SceneError({},
                             fmt::format("on so few incidences no phase function is reciprocal and has the "
                                         "scattering of each at {:g} nm: {} found; expected more incidences",
                                         Settings().wavelengths[wavelength], grid.NumIncidences()));
    return row;
}

OrientedBulkTable OrientedComputation::Table() const {
    OrientedBulkTable table;
    table.mode = ModeName(Settings().mode);
    table.hostIndex = Settings().hostIndex;
    table.wavelengths = Settings().wavelengths;
    table.angles = AnglesDeg(oriented_);
    table.numAzimuths = oriented_.numAzimuths;
    const OrientedGrid grid(table);
    const size_t perIncidence = grid.NumAngles() * grid.NumAzimuths();
    for (size_t w = 0; w < table.wavelengths.size(); ++w) {
        Row row = RowOf(AverageAt(w), w);
        const double mean = grid.MeanOverIncidences(row.sigmaS);
        table.g.push_back(std::clamp(MeanCosine(grid, table.angles, row.scattered) / mean, -1., 1.));
        std::vector<float>& p = table.phase.emplace_back();
        for (size_t at = 0; at < row.scattered.size(); ++at)
            p.push_back(float(row.scattered[at] / row.sigmaS[at / perIncidence]));
        table.errorReciprocity.push_back(row.reciprocityError);
        std::vector<Row> without;
        for (const OrientedAverage& average : sums_[w].AveragesWithoutGroups(Settings().mode))
            without.push_back(RowOf(average, w));
        if (!without.empty()) {
            const auto errorOf = [&](auto&& value) {
                std::vector<double> values;
                for (const Row& each : without) values.push_back(value(each));
                return JackknifeError(values);
            };
            table.errorSigmaS.push_back(
                errorOf([&](const Row& each) { return grid.MeanOverIncidences(each.sigmaS); }));
            table.errorSigmaA.push_back(
                errorOf([&](const Row& each) { return grid.MeanOverIncidences(each.sigmaA); }));
            std::vector<double> errors, integrals;
            for (size_t at = 0; at < row.scattered.size(); ++at)
                errors.push_back(errorOf([&](const Row& each) { return each.scattered[at]; }));
            for (size_t i = 0; i < grid.NumIncidences(); ++i)
                integrals.push_back(grid.OverSphere<double>(errors, i));
            table.errorPhase.push_back(grid.MeanOverIncidences(integrals) / mean);
        }
        table.sigmaS.push_back(std::move(row.sigmaS));
        table.sigmaA.push_back(std::move(row.sigmaA));
    }
    return table;
}

double MemoryOfOriented(const BulkSettings& settings, const OrientedSettings& oriented) {
    const Ensemble ensemble(OrientedOnes(settings).ensemble);
    const double numIncidences = oriented.numIncidences, numWavelengths = double(settings.wavelengths.size());
    // Realisations that are solved, groups of sums; and for one wavelength the averages and rows without each
    // group and with all.
    const double batch = OrientedComputation::BatchSizeFor(settings.wavelengths.size());
    const double kept = numWavelengths * (batch + OrientedSums::kNumGroups);
    const double passing = 2 * (OrientedSums::kNumGroups + 1);
    const double intensities = numIncidences * (2 * numIncidences - 1) * oriented.numAzimuths;
    const double degree = DegreesAt(settings, ensemble, settings.wavelengths.front()).farField;
    const double waves = numIncidences * 2 * 2 * degree * (degree + 2);
    return (kept + passing) * (intensities * double(sizeof(double)) + waves * double(sizeof(Complex)));
}

}  // namespace lacquer::bulk
