#include "estimate/output/predictive_check.h"

#include <algorithm>
#include <cmath>

#include "estimate/emulator/runs.h"

namespace lacquer::estimate {

std::vector<PredictiveCheck> CheckPredictions(const Simulator& simulator, const Matrix& draws,
                                              const Vector& observed, uint64_t seed) {
    const Matrix predicted = RunSimulator(simulator, draws, seed).summaries;
    const auto count = double(predicted.rows());
    std::vector<PredictiveCheck> checks;
    for (Eigen::Index j = 0; j < predicted.cols(); ++j) {
        const auto values = predicted.col(j).array();
        const double mean = values.mean();
        const auto above = double((values >= observed[j]).count()),
                   below = double((values <= observed[j]).count());
        checks.push_back({.summary = simulator.SummaryNames()[size_t(j)],
                          .observed = observed[j],
                          .mean = mean,
                          .sd = std::sqrt((values - mean).square().sum() / std::max(1., count - 1)) + 1e-300,
                          .pValue = std::min(1., 2 * (1 + std::min(above, below)) / (count + 1))});
    }
    std::stable_sort(checks.begin(), checks.end(), [](const PredictiveCheck& a, const PredictiveCheck& b) {
        return a.pValue != b.pValue ? a.pValue < b.pValue : std::abs(a.Residual()) > std::abs(b.Residual());
    });
    return checks;
}

}  // namespace lacquer::estimate
