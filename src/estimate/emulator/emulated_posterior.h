// The posterior distribution by waves of simulations: the default method.
#pragma once

#include <memory>
#include <vector>

#include "estimate/emulator/regression_coordinates.h"
#include "estimate/emulator/runs.h"
#include "estimate/emulator/summary_emulator.h"
#include "estimate/infer/population.h"
#include "estimate/infer/target.h"
#include "estimate/simulator.h"

namespace lacquer::estimate {

/// Posterior density of logits: prior with its Jacobian, times the likelihood of an emulator.
class EmulatedTarget final : public Target {
  public:
    /// @param space     outlives the object
    /// @param emulator  of regression coordinates
    /// @param inflation  of the covariance, tau^2: 1 where observations are samples of the model
    EmulatedTarget(const ParameterSpace& space, std::shared_ptr<const SummaryEmulator> emulator,
                   const Vector& observed, double inflation = 1)
        : space_(space),
          coordinates_(space),
          emulator_(std::move(emulator)),
          projected_(emulator_->Project(observed)),
          inflation_(inflation) {}
    Eigen::Index Size() const override { return Eigen::Index(space_.Size()); }
    double LogDensity(const Vector& y, Vector* gradient) const override;
    /// Without the prior.
    double LogLikelihood(const Vector& y, Vector* gradient = nullptr) const;
    /// Variance that few simulations add to the likelihood, over what it would be with many.
    double Leverage(const Vector& y) const { return emulator_->Leverage(coordinates_.FromLogits(y)); }
    std::shared_ptr<const SummaryEmulator> SharedEmulator() const { return emulator_; }

  private:
    const ParameterSpace& space_;
    RegressionCoordinates coordinates_;
    std::shared_ptr<const SummaryEmulator> emulator_;
    Vector projected_;
    double inflation_;
};

/// How an emulated posterior is found.
struct EmulationOptions {
    uint64_t seed = 1;
    Eigen::Index priorRuns = 900;  ///< of wave 0
    /// A wave after it: simulations (for up to 12 parameters; for more as many more), and how much wider than
    /// the last posterior they lie, in variance.
    struct Wave {
        Eigen::Index runs;
        double widening;
        /// The likelihood of the wave before to the power 1 / temperature: early emulators err by more than
        /// they know, all summaries together, and a wave that lies beside the truth does not come back to it.
        double temperature = 1;
    };
    /// After the last one it is repeated while the posterior still moves.
    std::vector<Wave> waves = {{400, 2, 16}, {400, 2, 6}, {450, 2, 2.5}, {500, 2, 1}, {600, 1.5, 1}};
    int maxWaves = 12;
    /// Of the means, in posterior deviations, between waves: beyond what the errors of two emulators that are
    /// both right let them move.
    double tolerance = 0.2;
    Eigen::Index numWalks = 80;
    /// Steps of each walk after its warm-up, which has as many.
    uint64_t walkSteps = 100, walkStepsPerParameter = 20;
    /// A misfit over the number of summaries above this is one that the model does not explain.
    double maxMisfit = 1.5;
    SummaryEmulator::Options emulator;
};

/// What a wave found.
struct WaveReport {
    Eigen::Index runs;    ///< simulations that its emulator was made from
    double shift;         ///< of the means since the wave before, in deviations; the largest
    double allowedShift;  ///< tolerance, and what the emulators' own errors let the means move, in squares
    double misfit;  ///< of all summaries at the mean, over the number of summaries: about 1 where the model
                    ///< is right
    double acceptance, maxRhat;  ///< of the walks
};

struct EmulatedPosterior {
    std::shared_ptr<const EmulatedTarget> target;
    PopulationDraws draws;  ///< of the last wave, in logits
    std::vector<WaveReport> waves;
    Eigen::Index numRuns = 0;  ///< simulations in all
    /// By how many of its standard deviations the model misses what was observed: the covariance has been
    /// multiplied by tau^2 = misfit / (summaries - parameters) where the misfit was above maxMisfit; else 1.
    double tau = 1;
    bool hasConverged = false;  ///< the last wave moved the means by less than it may
};

/// Wave 0: draws of the prior, one seed each. Does not depend on what was observed, so many observations can
/// share it.
Runs RunPrior(const Simulator& simulator, const EmulationOptions& options, RunLog* log = nullptr,
              Observer* observer = nullptr);
/// The posterior of `observed` summaries. Wave 0's emulator spans the prior; each later wave simulates where
/// the posterior of the one before lies, widened, and uses all earlier simulations in its region as well.
/// The same bits for any number of threads. Errors: Interrupted, if the observer asks to stop.
EmulatedPosterior EmulatePosterior(const Simulator& simulator, const Vector& observed, const Runs& priorRuns,
                                   const EmulationOptions& options, RunLog* log = nullptr,
                                   Observer* observer = nullptr);

}  // namespace lacquer::estimate
