// What `lacquer bulk` is about to do, and what speaks against it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "bulk/input/particles_input.h"
#include "bulk/table/ensemble_computation.h"

namespace lacquer::cmd {

/// Of one computation. Degrees, sizes and unknowns are those at the shortest wavelength.
struct BulkPlan {
    int count = 0;
    double ballRadius = 0, ballSize = 0;  ///< of all particles [um], and times k
    double opticalDepth = 0;  ///< largest one of the ball's diameter, of independent particles; 0: no ball
    double depthWavelength = 0;
    int degree = 0, farDegree = 0;
    int numAngles = 0;  ///< of scattered light
    std::optional<bulk::OrientedSettings> oriented;
    double unknowns = 0, memory = 0;  ///< of one polarisation; bytes
    /// Of all wavelengths and incidences, with all threads; 0: was not measured.
    double secondsPerRealization = 0;
};
/// Products of a solution that plans reckon with: 14 to 31 were counted for 30 to 100 spheres.
inline constexpr int kPlannedProducts = 20;

/// Settings of each computation of an input: one, or one for each size of the ball.
std::vector<bulk::BulkSettings> SettingsOf(const bulk::ParticlesInput& input);
/// @param oriented  empty: of an ensemble without an axis
BulkPlan PlanOf(const bulk::BulkSettings& settings,
                const std::optional<bulk::OrientedSettings>& oriented = std::nullopt);
/// Fills in the time, by doing a small part of the work. Takes about a second; for oriented ensembles with
/// narrow lobes some.
void MeasureTime(const bulk::BulkSettings& settings, BulkPlan* plan);
/// Lines for a person.
std::string ToText(const BulkPlan& plan, int numRealizations);
/// Cross sections of one wavelength.
struct EnergyBalance {
    double extinction = 0, scattering = 0, absorption = 0;
};
/// That the average "chapter" does not conserve energy, and by how much at most.
std::string WarningOfChapter(const std::vector<EnergyBalance>& ofWavelengths);
/// Why the result may be wrong.
std::vector<std::string> WarningsOf(const bulk::BulkSettings& settings, const BulkPlan& plan);

}  // namespace lacquer::cmd
