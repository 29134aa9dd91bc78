// As many numbers as parameters in place of many summaries.
#pragma once

#include "estimate/linear_algebra.h"

namespace lacquer::estimate {

/// Linear regressions of the parameters on the summaries: one number for each parameter, which of all linear
/// ones tells most about it where the simulations lie [Fearnhead and Prangle 2012]. The posterior given these
/// numbers is as right as that given all summaries, a little wider, and needs the scatter of a few numbers
/// rather than of a hundred correlated ones, some of which hardly vary.
class RegressionSummaries {
  public:
    RegressionSummaries() = default;
    /// @param summaries   a row for each simulation
    /// @param parameters  a row for each simulation, in any coordinates
    /// Summaries that do not vary are left out. Each regression has a ridge of its own, the best by leaving
    /// out one simulation at a time [Allen 1974].
    RegressionSummaries(const Matrix& summaries, const Matrix& parameters);
    /// The summaries themselves, in units of their spread: where they are few, nothing is to be lost.
    explicit RegressionSummaries(const Matrix& summaries);
    Eigen::Index Size() const { return weights_.cols(); }
    Vector Apply(const Vector& summaries) const {
        return weights_.transpose() * (summaries - means_).cwiseProduct(inverseSds_);
    }
    /// For each simulation (row) what regressions without it make of its summaries. What has been fitted to a
    /// simulation is nearer to it than to any new one, and must not be taken for its scatter.
    const Matrix& LeftOut() const { return leftOut_; }
    /// Variance that the errors of the regressions add, over that of one simulation; the mean over parameters
    /// and simulations.
    double Leverage() const { return leverage_; }

  private:
    /// Sets means and deviations; the summaries in these units.
    Matrix Standardize(const Matrix& summaries);

    Vector means_, inverseSds_;
    Matrix weights_;  ///< a column for each parameter
    Matrix leftOut_;
    double leverage_ = 0;
};

}  // namespace lacquer::estimate
