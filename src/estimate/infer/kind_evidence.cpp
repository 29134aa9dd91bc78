#include "estimate/infer/kind_evidence.h"

#include <algorithm>
#include <cmath>

#include "estimate/covariance/shrinkage.h"
#include "estimate/emulator/runs.h"
#include "estimate/infer/population.h"

namespace lacquer::estimate {

std::vector<double> KindProbabilities(const std::vector<KindPosterior>& kinds, const Vector& observed,
                                      Eigen::Index runs, uint64_t seed) {
    if (kinds.size() == 1) return {1};
    const auto count = Eigen::Index(kinds.size()), size = observed.size();
    Matrix means(count, size), residuals(count * runs, size);
    for (Eigen::Index k = 0; k < count; ++k) {
        const KindPosterior& kind = kinds[size_t(k)];
        const Vector y = kind.draws.rowwise().mean();
        const Matrix summaries =
            RunSimulator(*kind.simulator, y.replicate(1, runs), Hash(seed, uint64_t(k))).summaries;
        means.row(k) = summaries.colwise().mean();
        residuals.middleRows(k * runs, runs) = summaries.rowwise() - means.row(k);
    }
    const auto degrees = double(count * (runs - 1));
    const ResidualLikelihood likelihood(ShrinkCorrelations(residuals, degrees), degrees,
                                        CovarianceError::Student);
    Vector logEvidence(count);
    for (Eigen::Index k = 0; k < count; ++k) {
        const KindPosterior& kind = kinds[size_t(k)];
        const Vector residual = observed - means.row(k).transpose();
        // The mean of the simulations errs as well.
        const double misfit = likelihood.Misfit(residual) / (1 + 1 / double(runs));
        const Matrix root = CholeskyFactor(CovarianceOfColumns(kind.draws));
        logEvidence[k] = likelihood.LogOfMisfit(misfit) +
                         kind.simulator->Parameters().LogPriorOfLogit(kind.draws.rowwise().mean()) +
                         root.diagonal().array().log().sum();
    }
    Vector probabilities = (logEvidence.array() - logEvidence.maxCoeff()).exp().matrix();
    probabilities /= probabilities.sum();
    return {probabilities.begin(), probabilities.end()};
}

}  // namespace lacquer::estimate
