// Does the model explain all summaries at once?
#pragma once

#include "estimate/covariance/projection.h"
#include "estimate/covariance/shrinkage.h"
#include "estimate/emulator/polynomial_basis.h"

namespace lacquer::estimate {

/// How far observed summaries are from those that a model gives, all of them rather than the few by which the
/// parameters are estimated: a photograph of something else can be fitted in few numbers, and in all of them
/// it cannot.
class ModelCheck {
  public:
    ModelCheck() = default;
    /// Of simulations, as SummaryEmulator.
    ModelCheck(const Matrix& parameters, const Matrix& summaries, int degree);
    /// Squared residual of the mean over draws, a column for each, in units of the covariance of the
    /// simulations and of the draws together, over the number of summaries: about 1, or less, where the model
    /// is right.
    double Misfit(const Matrix& draws, const Vector& summaries) const;
    Eigen::Index NumSummaries() const { return projection_.Size(); }

  private:
    PolynomialBasis basis_;
    SummaryProjection projection_;
    Matrix coefficients_;
    Matrix residuals_;  ///< a row for each simulation
};

}  // namespace lacquer::estimate
