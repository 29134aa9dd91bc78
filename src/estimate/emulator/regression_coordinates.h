// Coordinates in which regressions are made.
#pragma once

#include <vector>

#include "estimate/parameters.h"

namespace lacquer::estimate {

/// The standard normal variable that has the same rank as one of a cut normal distribution.
class NormalScore {
  public:
    explicit NormalScore(const TruncatedNormal& distribution);
    /// Within 7 of 0: ranks nearer to 0 and 1 are not told apart.
    /// @param slope  its derivative, if not null
    double Of(double x, double* slope = nullptr) const;

  private:
    double mean_, sd_, sign_, below_, mass_;
};

/// Coordinates of parameters for polynomials. Each is the standard normal variable that has the parameter's
/// rank in its prior, so that no parameter has long tails: a prior with mass at a bound is exponential in
/// logits, and polynomials of these are of no use at their ends. Of a factor (Parameter::productWith) it is
/// the root of the product, in which the values of photographs are nearly linear and which ends at zero.
class RegressionCoordinates {
  public:
    /// @param space  outlives the object
    explicit RegressionCoordinates(const ParameterSpace& space);
    /// Of columns of logits.
    Matrix FromLogits(const Matrix& y) const;
    /// d/dy of a function of coordinates, from its derivatives by them.
    Vector GradientByLogits(const Vector& y, const Vector& byCoordinates) const;

  private:
    const ParameterSpace& space_;
    std::vector<NormalScore> scores_;
    std::vector<Eigen::Index> scales_;  ///< for each parameter the one that it multiplies, or -1
};

}  // namespace lacquer::estimate
