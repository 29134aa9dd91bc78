// One realisation of an ensemble, solved for one wavelength.
#pragma once

#include <span>

#include "bulk/averages/scattering_sums.h"
#include "bulk/cluster/cluster.h"
#include "bulk/cluster/far_field.h"

namespace lacquer::bulk {

struct RealizationSettings {
    int extraDegree = 2;  ///< see Cluster
    SolverOptions solver;
    size_t memory = size_t(2) << 30;  ///< bytes for tables of pairs
};
/// Beyond it a solution is refused: its waves are not computed accurately.
inline constexpr double kLargestEnergyError = 1e-8;
/// |C_ext - C_abs - C_sca| over C_ext, if that is positive.
double EnergyError(double extinction, double absorption, double scattering);

/// What all solutions say of themselves.
struct Solution {
    virtual ~Solution() = default;
    int numProducts = 0;
    bool hasConverged = true;  ///< and energy balances to 1e-8
    /// |C_ext - C_abs - C_sca| over C_ext, for the incident waves that the solver did solve exactly:
    /// rounding.
    double energyError = 0;
};

struct SolvedRealization final : Solution {
    RealizationScattering scattering;
};
/// @param spheres     about the origin, lengths times k; none scatter nothing
/// @param harmonics   at the angles of the averages; of at least FarFieldDegree() of the cluster
SolvedRealization SolveRealization(std::vector<Sphere> spheres, const RealizationSettings& settings,
                                   const AzimuthalHarmonics& harmonics);

/// j pi / n for j = 0 ... n, for ScatteringSums.
std::vector<double> EvenAngles(int n);

}  // namespace lacquer::bulk
