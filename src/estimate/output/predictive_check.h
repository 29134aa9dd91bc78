// Does what was observed look like what the posterior predicts?
#pragma once

#include <string>
#include <vector>

#include "estimate/simulator.h"

namespace lacquer::estimate {

/// One summary of what was observed among those of runs at draws of the posterior, with fresh seeds.
struct PredictiveCheck {
    std::string summary;
    double observed, mean, sd;  ///< mean and deviation of the predictions
    double pValue;  ///< two-sided rank of the observation: 2 / (n + 1) at the least for n predictions
    /// In deviations of the predictions.
    double Residual() const { return (observed - mean) / sd; }
};

/// Predictive checks of all summaries, in ascending order of their p-values, then by the size of the
/// residual. In parallel; the same for any number of threads.
/// @param simulator  the one that was estimated with, or one of the same parameters with summaries that were
///                   held out
/// @param draws      logits, a column for each run
std::vector<PredictiveCheck> CheckPredictions(const Simulator& simulator, const Matrix& draws,
                                              const Vector& observed, uint64_t seed);

}  // namespace lacquer::estimate
