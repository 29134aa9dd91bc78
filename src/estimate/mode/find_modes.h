// The best parameters: modes of the posterior in natural units.
#pragma once

#include <vector>

#include "estimate/covariance/fixed_seed.h"
#include "pbrt/core/progress.h"

namespace lacquer::estimate {

struct ModeOptions {
    uint64_t seed = 1;
    int numDraws = 64;  ///< of the prior, of which the best ones are starts
    int numStarts = 4;
    int adamSteps = 80;  ///< of each start, where the simulator has gradients [Kingma and Ba 2015]
    double firstRate = 0.08, lastRate = 0.008;  ///< of Adam, in logits
    int maxIterations = 25;                     ///< of Levenberg and Marquardt's method after that
    double difference = 1e-3;                   ///< of its derivatives, in logits
};

/// A local minimum of the energy.
struct Mode {
    Vector y;  ///< logits
    double energy;
    double misfit;  ///< over the number of summaries: about 1 where the model is right
};

/// Modes in ascending order of their energy: the best one, and those within 2 of it that are elsewhere (by
/// more than 0.05 in some logit). Several starts are no luxury: minima differ by hundreds. Derivatives of the
/// least-squares steps are differences with common random numbers. The same for any number of threads.
std::vector<Mode> FindModes(const FixedSeedTarget& target, const ModeOptions& options,
                            Observer* observer = nullptr);

/// Covariance of logits at a point, by the residuals' derivatives there: that of Gauss and Newton, good as a
/// metric and for starts, too narrow for intervals.
Matrix CovarianceAt(const FixedSeedTarget& target, const Vector& y);

}  // namespace lacquer::estimate
