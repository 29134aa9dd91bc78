#include "bulk/table/oriented_computation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bulk/table/bulk_problem.h"
#include "pbrt/core/check.h"
#include "pbrt/core/error.h"
#include "pbrt/core/parallel.h"
#include "pbrt/scattering/oriented_table.h"

namespace lacquer::bulk {
namespace {

/// Realisations that are solved at a time, so that threads have work and the sums their order.
constexpr int kBatch = 4;

BulkSettings Oriented(BulkSettings settings) {
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
    : settings_(Oriented(std::move(settings))), oriented_(oriented), ensemble_(settings_.ensemble) {
    LACQUER_CHECK(settings_.method == BulkMethod::Clusters && !settings_.wavelengths.empty() &&
                  settings_.indices.size() == settings_.ensemble.species.size());
    directions_.reserve(settings_.wavelengths.size());  // sums refer to them
    for (size_t w = 0; w < settings_.wavelengths.size(); ++w) {
        const int degree = DegreesAt(settings_, ensemble_, settings_.wavelengths[w]).farField;
        directions_.emplace_back(oriented_.numIncidences, oriented_.numAzimuths, degree);
        sums_.emplace_back(directions_.back());
    }
}

void OrientedComputation::AddRealizations(int count, Observer* observer) {
    const int64_t numWavelengths = int64_t(settings_.wavelengths.size());
    RealizationSettings each = settings_.realization;
    each.memory /= size_t(std::max(1, std::min(MaxThreads(), int(kBatch * numWavelengths))));
    for (int done = 0; done < count; done += kBatch) {
        if (observer && observer->ShouldStop()) return;
        const int size = std::min(kBatch, count - done);
        std::vector<std::vector<Particle>> particles;
        for (int i = 0; i < size; ++i)
            particles.push_back(ensemble_.Realize(settings_.seed, uint64_t(numRealizations_ + i)));
        std::vector<OrientedRealization> solved(size_t(size * numWavelengths));
        ParallelFor(int64_t(solved.size()), [&](int64_t task) {
            if (observer && observer->ShouldStop()) return;
            const size_t r = size_t(task / numWavelengths), w = size_t(task % numWavelengths);
            solved[size_t(task)] = SolveOriented(SpheresOf(settings_, particles[r], settings_.wavelengths[w]),
                                                 each, directions_[w], observer);
            if (observer) observer->Advance(1);
        });
        if (observer && observer->ShouldStop()) return;
        for (size_t task = 0; task < solved.size(); ++task) {
            if (!solved[task].hasConverged) {
                ++numRefused_;
                continue;
            }
            worstEnergyError_ = std::max(worstEnergyError_, solved[task].energyError);
            sums_[task % size_t(numWavelengths)].Add(solved[task]);
        }
        numRealizations_ += size;
    }
}

/// A wavelength of the table, per millimetre.
struct OrientedComputation::Row {
    std::vector<double> sigmaS, sigmaA, scattered;
    double reciprocityError = 0;
};

OrientedComputation::Row OrientedComputation::RowOf(const OrientedAverage& average, size_t wavelength) const {
    const double perMillimetre = CoefficientOfUnit(settings_, ensemble_, settings_.wavelengths[wavelength]);
    Row row;
    for (const OrientedAverage::Incidence& found : average.incidences) {
        if (!(found.scattering > 0))
            throw SceneError({},
                             fmt::format("{} realisations leave no scattering at {} nm in some direction; "
                                         "expected more of them",
                                         numRealizations_, settings_.wavelengths[wavelength]));
        row.sigmaS.push_back(found.scattering * perMillimetre);
        row.sigmaA.push_back(found.absorption * perMillimetre);
        // Differences of estimates may be negative where there is hardly any light.
        for (const double value : found.intensity)
            row.scattered.push_back(std::max(0., value) * perMillimetre);
    }
    const OrientedGrid grid(AnglesDeg(oriented_), oriented_.numAzimuths);
    row.reciprocityError = MakeReciprocal(grid, row.sigmaS, row.scattered);
    return row;
}

OrientedBulkTable OrientedComputation::Table() const {
    OrientedBulkTable table;
    table.mode = ModeName(settings_.mode);
    table.hostIndex = settings_.hostIndex;
    table.wavelengths = settings_.wavelengths;
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
        for (const OrientedAverage& average : sums_[w].AveragesWithoutGroups(settings_.mode))
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
    const Ensemble ensemble(Oriented(settings).ensemble);
    const double numIncidences = oriented.numIncidences, numWavelengths = double(settings.wavelengths.size());
    // Realisations that are solved, groups of sums; and for one wavelength the averages and rows without each
    // group and with all.
    const double kept = numWavelengths * (kBatch + OrientedSums::kNumGroups);
    const double passing = 2 * (OrientedSums::kNumGroups + 1);
    const double intensities = numIncidences * (2 * numIncidences - 1) * oriented.numAzimuths;
    const double degree = DegreesAt(settings, ensemble, settings.wavelengths.front()).farField;
    const double waves = numIncidences * 2 * 2 * degree * (degree + 2);
    return (kept + passing) * (intensities * double(sizeof(double)) + waves * double(sizeof(Complex)));
}

}  // namespace lacquer::bulk
