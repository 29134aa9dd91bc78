// Covariances of summaries from few simulations.
#pragma once

#include <cmath>

#include "estimate/linear_algebra.h"

namespace lacquer::estimate {

/// A covariance whose correlations have been pulled towards zero.
struct ShrunkCovariance {
    Matrix covariance;
    double intensity;  ///< how far, from 0 to 1
};
/// Covariance with correlations multiplied by 1 - intensity, which makes it invertible for fewer samples than
/// dimensions and loses least in the mean [Ledoit and Wolf 2004; Schaefer and Strimmer 2005].
/// @param residuals  a row for each simulation, with their means (or a regression) subtracted
/// @param degrees    degrees of freedom that are left: rows minus what was fitted to each column
/// @param minIntensity  of the shrinkage
ShrunkCovariance ShrinkCorrelations(const Matrix& residuals, double degrees, double minIntensity = 0);

/// What the inverse of a covariance from simulations must be multiplied by to be unbiased
/// [Hartlap et al. 2007]; at least 0.05.
/// @param degrees  as above: one less than the number of simulations for a plain covariance
double HartlapFactor(double degrees, Eigen::Index dimensions);

/// How uncertainty of the covariance enters the likelihood.
enum class CovarianceError {
    Hartlap,  ///< normal, with the unbiased inverse
    Student   ///< a t distribution: the covariance is integrated over [Sellentin and Heavens 2016]
};

/// Likelihood of normal residuals whose covariance comes from simulations.
class ResidualLikelihood {
  public:
    ResidualLikelihood() = default;
    ResidualLikelihood(const ShrunkCovariance& covariance, double degrees, CovarianceError error);
    /// Squared length of a residual by the inverse of the covariance, without Hartlap's factor.
    double Misfit(const Vector& residual) const { return residual.dot(precision_ * residual); }
    /// A vector whose squared length is the misfit, times Hartlap's factor if that is in use.
    Vector Whitened(const Vector& residual) const {
        return std::sqrt(error_ == CovarianceError::Hartlap ? factor_ : 1.) * (root_.transpose() * residual);
    }
    /// C^-1 residual, by the same.
    Vector Weighted(const Vector& residual) const { return precision_ * residual; }
    /// Logarithm of the likelihood as a function of the misfit, up to a constant, and its derivative.
    double LogOfMisfit(double misfit, double* slope = nullptr) const;
    Eigen::Index Size() const { return precision_.rows(); }

  private:
    Matrix precision_, root_;  ///< precision = root root^T
    double degrees_ = 0, factor_ = 1;
    CovarianceError error_ = CovarianceError::Hartlap;
};

}  // namespace lacquer::estimate
