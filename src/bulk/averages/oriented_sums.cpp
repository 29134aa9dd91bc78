#include "bulk/averages/oriented_sums.h"

#include <algorithm>
#include <cmath>

#include "pbrt/core/check.h"

namespace lacquer::bulk {

OrientedDirections::OrientedDirections(int numIncidences, int numAzimuths, int degree)
    : harmonics(degree, EvenAngles(2 * (numIncidences - 1))), azimuths(degree, numAzimuths) {
    LACQUER_CHECK(numIncidences >= 2);
}

double OrientedDirections::Angle(int i) const { return EvenAngles(NumAngles() - 1)[size_t(i)]; }

namespace {

std::vector<double> IntensityOf(const OneOriginWaves& waves, const OrientedDirections& directions) {
    std::vector<double> intensity;
    for (int j = 0; j < directions.NumAngles(); ++j) {
        const Eigen::VectorXd around = IntensityAround(waves, directions.harmonics, j, directions.azimuths);
        intensity.insert(intensity.end(), around.begin(), around.end());
    }
    return intensity;
}

}  // namespace

OrientedRealization SolveOriented(std::vector<Sphere> spheres, const RealizationSettings& settings,
                                  const OrientedDirections& directions) {
    OrientedRealization result;
    const int degree = directions.harmonics.Degree();
    result.incidences.resize(size_t(directions.NumIncidences()));
    if (spheres.empty()) {
        for (OrientedRealization::Incidence& found : result.incidences) {
            found.waves = {degree, Eigen::MatrixX2cd::Zero(2 * NumHarmonics(degree), 2)};
            found.intensity = IntensityOf(found.waves, directions);
        }
        return result;
    }
    const Cluster cluster(std::move(spheres), settings.extraDegree);
    const ClusterSolver solver(cluster, settings.memory);
    result.numParticles = cluster.NumSpheres();
    std::vector<HelicityWaves> all;
    for (int i = 0; i < directions.NumIncidences(); ++i) {
        OrientedRealization::Incidence& found = result.incidences[size_t(i)];
        ScatteredWaves scattered =
            solver.Solve(IncidentWaves(cluster, {directions.Angle(i), 0}), settings.solver);
        found.extinction = ExtinctionOfSolved(cluster, scattered).mean();
        found.absorption = AbsorptionOf(cluster, scattered.coefficients).mean();
        result.numProducts += scattered.numProducts;
        result.hasConverged &= scattered.hasConverged;
        all.push_back(std::move(scattered.coefficients));
    }
    std::vector<OneOriginWaves> waves = AboutOrigin(cluster, all, degree);
    for (size_t i = 0; i < waves.size(); ++i) {
        OrientedRealization::Incidence& found = result.incidences[i];
        found.waves = std::move(waves[i]);
        found.scattering = found.waves.Scattering().mean();
        found.intensity = IntensityOf(found.waves, directions);
        const double missing = std::abs(found.extinction - found.absorption - found.scattering);
        result.energyError =
            std::max(result.energyError, found.extinction > 0 ? missing / found.extinction : missing);
    }
    result.hasConverged &= result.energyError < kLargestEnergyError;
    return result;
}

void OrientedSums::Sums::Add(const Sums& other) {
    count += other.count;
    numParticles += other.numParticles;
    if (incidences.empty()) {
        incidences = other.incidences;
        return;
    }
    for (size_t i = 0; i < other.incidences.size(); ++i) {
        Incidence& sum = incidences[i];
        const Incidence& more = other.incidences[i];
        sum.extinction += more.extinction;
        sum.absorption += more.absorption;
        sum.scattering += more.scattering;
        sum.coefficients += more.coefficients;
        for (size_t k = 0; k < more.intensity.size(); ++k) sum.intensity[k] += more.intensity[k];
    }
}

void OrientedSums::Add(const OrientedRealization& realization) {
    LACQUER_CHECK(int(realization.incidences.size()) == directions_->NumIncidences());
    Sums one{1, realization.numParticles, {}};
    for (const OrientedRealization::Incidence& found : realization.incidences)
        one.incidences.push_back({found.extinction, found.absorption, found.scattering,
                                  found.waves.coefficients, found.intensity});
    groups_[size_t(numRealizations_++ % kNumGroups)].Add(one);
}

OrientedAverage OrientedSums::Evaluate(const Sums& sums, AverageMode mode) const {
    OrientedAverage average;
    // From pairs of different realisations: |sum F|^2 less the sum of |F|^2, over (count - 1), for each.
    const double perPair = mode == AverageMode::Aggregate ? 0 : 1 / (sums.count - 1);
    const double perParticle = sums.numParticles > 0 ? 1 / sums.numParticles : 0;
    for (const Incidence& sum : sums.incidences) {
        const OneOriginWaves all{directions_->harmonics.Degree(), sum.coefficients};
        OrientedAverage::Incidence& found = average.incidences.emplace_back();
        const auto ofMode = [&](double total, double ofSum) {
            const double coherent = (ofSum - total) * perPair;
            return perParticle * (mode == AverageMode::Chapter ? coherent : total - coherent);
        };
        found.extinction = sum.extinction * perParticle;
        found.absorption = sum.absorption * perParticle;
        found.scattering = ofMode(sum.scattering, all.Scattering().mean());
        found.intensity = sum.intensity;
        const std::vector<double> ofSum = perPair > 0 ? IntensityOf(all, *directions_) : sum.intensity;
        for (size_t k = 0; k < ofSum.size(); ++k) found.intensity[k] = ofMode(sum.intensity[k], ofSum[k]);
    }
    return average;
}

OrientedSums::Sums OrientedSums::SumWithout(int group) const {
    Sums sums;
    for (int g = 0; g < kNumGroups; ++g)
        if (g != group && groups_[size_t(g)].count > 0) sums.Add(groups_[size_t(g)]);
    return sums;
}

OrientedAverage OrientedSums::Average(AverageMode mode) const {
    LACQUER_CHECK(numRealizations_ >= (mode == AverageMode::Aggregate ? 1 : 2));
    return Evaluate(SumWithout(-1), mode);
}

std::vector<OrientedAverage> OrientedSums::AveragesWithoutGroups(AverageMode mode) const {
    std::vector<OrientedAverage> averages;
    if (numRealizations_ >= kNumGroups + 2)
        for (int g = 0; g < kNumGroups; ++g) averages.push_back(Evaluate(SumWithout(g), mode));
    return averages;
}

}  // namespace lacquer::bulk
