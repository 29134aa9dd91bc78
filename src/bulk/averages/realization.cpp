#include "bulk/averages/realization.h"

#include <numbers>

namespace lacquer::bulk {

std::vector<double> EvenAngles(int n) {
    std::vector<double> thetas;
    for (int j = 0; j <= n; ++j) thetas.push_back(j * std::numbers::pi / n);
    return thetas;
}

double EnergyError(double extinction, double absorption, double scattering) {
    const double missing = std::abs(extinction - absorption - scattering);
    return extinction > 0 ? missing / extinction : missing;
}

SolvedRealization SolveRealization(std::vector<Sphere> spheres, const RealizationSettings& settings,
                                   const AzimuthalHarmonics& harmonics) {
    SolvedRealization result;
    RealizationScattering& found = result.scattering;
    if (spheres.empty()) {
        found.angles.assign(size_t(harmonics.NumAngles()), {.amplitude = Eigen::Matrix2cd::Zero()});
        return result;
    }
    const Cluster cluster(std::move(spheres), settings.extraDegree);
    const HelicityWaves incident = IncidentWaves(cluster, {0, 0});
    const ScatteredWaves scattered = ClusterSolver(cluster, settings.memory).Solve(incident, settings.solver);
    const OneOriginWaves far = AboutOrigin(cluster, scattered.coefficients, FarFieldDegree(cluster));
    found.numParticles = cluster.NumSpheres();
    found.extinction = ExtinctionOfSolved(cluster, scattered).mean();
    found.absorption = AbsorptionOf(cluster, scattered.coefficients).mean();
    found.scattering = far.Scattering().mean();
    found.angles = AzimuthalMeansOf(far, harmonics);
    result.numProducts = scattered.numProducts;
    result.energyError = EnergyError(found.extinction, found.absorption, found.scattering);
    result.hasConverged = scattered.hasConverged && result.energyError < kLargestEnergyError;
    return result;
}

}  // namespace lacquer::bulk
