// Does what was observed look like what the posterior predicts?
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "estimate/linear_algebra.h"

namespace lacquer::estimate {

/// One summary of what was observed among those of runs at draws of the posterior, with fresh seeds.
struct PredictiveCheck {
    std::string summary;
    double observed, mean, sd;  ///< mean and deviation of the predictions
    double shareAbove;          ///< of the predictions above the observation, half of those that are equal
    double pValue;  ///< two-sided rank of the observation: 2 / (n + 1) at the least for n predictions
    /// In deviations of the predictions.
    double Residual() const { return (observed - mean) / std::max(sd, 1e-12); }
};

/// Predictive checks of all summaries, in their order.
/// @param names      of the summaries
/// @param predicted  a row for each run, as RunSimulator() gives them
std::vector<PredictiveCheck> CheckPredictions(const std::vector<std::string>& names, const Matrix& predicted,
                                              const Vector& observed);

}  // namespace lacquer::estimate
