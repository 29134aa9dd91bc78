#include "estimate/output/predictive_check.h"

#include <cmath>

namespace lacquer::estimate {

std::vector<PredictiveCheck> CheckPredictions(const std::vector<std::string>& names, const Matrix& predicted,
                                              const Vector& observed) {
    const auto count = double(predicted.rows());
    std::vector<PredictiveCheck> checks;
    for (Eigen::Index j = 0; j < predicted.cols(); ++j) {
        const auto values = predicted.col(j).array();
        const double mean = values.mean();
        const auto above = double((values > observed[j]).count()),
                   equal = double((values == observed[j]).count());
        checks.push_back(
            {.summary = names[size_t(j)],
             .observed = observed[j],
             .mean = mean,
             .sd = std::sqrt((values - mean).square().sum() / std::max(1., count - 1)),
             .shareAbove = (above + 0.5 * equal) / count,
             .pValue = std::min(1., 2 * (1 + std::min(above + equal, count - above)) / (count + 1))});
    }
    return checks;
}

}  // namespace lacquer::estimate
