// How probable measured values are, given predicted ones.
#pragma once

#include "estimate/linear_algebra.h"

namespace lacquer::estimate {

/// What is known of the error of predicted values besides the noise of measurements: independent variances,
/// and some directions in which all values err together.
struct PredictionError {
    Vector independent;  ///< variances
    Matrix common;       ///< a column for each direction, of unit variance; may have no columns
};

/// Logarithms of measured values are normal around predicted ones, with variance s^2 (the noise, which is
/// estimated), the variance that the measurement itself tells, and that of the prediction. Or they follow
/// Student's t with 4 degrees of freedom and that scale, which forgives outliers.
class LobeLikelihood {
  public:
    static constexpr double kDegrees = 4;
    /// @param observed    logarithms
    /// @param deviations  of them, as the measurement tells
    LobeLikelihood(Vector observed, const Vector& deviations, PredictionError error, bool isRobust);
    /// @param byMean, byNoise  derivatives; null: not wanted
    double Log(const Vector& mean, double noise, Vector* byMean, double* byNoise) const;
    /// Squared residuals over their variances, of the mean value: about 1 where noise explains them.
    double Misfit(const Vector& mean, double noise) const;
    const Vector& Observed() const { return observed_; }

  private:
    double LogOfNormal(const Vector& residual, double noise, Vector* byMean, double* byNoise) const;
    double LogOfStudent(const Vector& residual, double noise, Vector* byMean, double* byNoise) const;

    Vector observed_, variances_;  ///< beside s^2
    Matrix common_;
    Vector allVariances_;  ///< with those of the common directions
    bool isRobust_;
};

}  // namespace lacquer::estimate
