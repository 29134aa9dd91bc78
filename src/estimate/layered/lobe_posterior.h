// The posterior distribution of the parameters of layers, by waves of simulations.
#pragma once

#include <memory>
#include <vector>

#include "estimate/infer/population.h"
#include "estimate/layered/lobe_target.h"

namespace lacquer::estimate {

/// How a posterior is found.
struct LobeOptions {
    uint64_t seed = 1;
    /// Simulations of wave 0, of each later one, and the most that an emulator is made from.
    Eigen::Index priorRuns = 80, priorRunsPerParameter = 50;
    Eigen::Index waveRuns = 60, waveRunsPerParameter = 20;
    Eigen::Index maxEmulatorRuns = 420;
    int minWaves = 2, maxWaves = 7;
    /// Of the means, in posterior deviations, between waves: beyond what the errors of both emulators let
    /// them move.
    double tolerance = 0.2;
    Eigen::Index numWalks = 80;
    uint64_t walkSteps = 120, walkStepsPerParameter = 20;
    bool isRobust = false;
    bool errsTogether = false;  ///< LobeEmulator::Options
    /// The least deviation of simulations of a wave, in errors with which one simulation would tell the
    /// parameters; 0: no limit. Where simulations are far noisier than what was observed, waves of the
    /// posterior's width would have nothing but noise in them, which looks like a change with the parameters:
    /// posteriors that are far too narrow, and narrower from wave to wave.
    double leastWidth = 0;
    double errorScale = 1;  ///< of the emulators' errors; others than 1 are wrong, for tests of tests
};

/// What a wave found.
struct LobeWave {
    Eigen::Index runs;           ///< that its emulator was made from
    double shift;                ///< of the means since the wave before, in deviations; the largest
    double allowedShift;         ///< tolerance, plus what the emulators' own errors let the means move
    double errorShare;           ///< of the emulator's variance in that of the residuals, in the components
    double misfit;               ///< at the mean: about 1, as the noise is estimated
    double acceptance, maxRhat;  ///< of the walks
};

struct LobePosterior {
    std::shared_ptr<const LobeTarget> target;  ///< of the last wave
    PopulationDraws draws;                     ///< in logits, with the noise
    std::vector<LobeWave> waves;
    Eigen::Index numRuns = 0;
    bool hasConverged = false;  ///< the last wave moved the means by less than it may
};

/// Wave 0: draws of the prior, which many observations can share.
/// @param simulator  whose summaries are all values (positive), then their standard errors
Runs RunLobePrior(const Simulator& simulator, const LobeOptions& options, RunLog* log = nullptr,
                  Observer* observer = nullptr);
/// @param space        WithNoise(simulator.Parameters()); it and the coordinates of its model's parameters
///                     outlive the result
/// The same bits for any number of threads. Errors: Interrupted, if the observer asks to stop.
LobePosterior FindLobePosterior(const Simulator& simulator, const ParameterSpace& space,
                                const LobeCoordinates& coordinates, const ObservedLobes& observed,
                                const Runs& priorRuns, const LobeOptions& options, RunLog* log = nullptr,
                                Observer* observer = nullptr);

/// Columns of logits without the noise.
inline Matrix WithoutNoise(const Matrix& y) { return y.topRows(y.rows() - 1); }

}  // namespace lacquer::estimate
