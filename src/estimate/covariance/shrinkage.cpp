#include "estimate/covariance/shrinkage.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace lacquer::estimate {

ShrunkCovariance ShrinkCorrelations(const Matrix& residuals, double degrees, double minIntensity) {
    const auto n = double(residuals.rows());
    // A summary that never changes has no scale of its own; any small one makes its residual count.
    const Vector sds = ((residuals.colwise().squaredNorm() / degrees).array().sqrt() + 1e-12).matrix();
    const Matrix z = residuals * sds.cwiseInverse().asDiagonal();
    Matrix correlations = z.transpose() * z / degrees;
    // var(r_ij) from the spread of the products that r_ij is the mean of.
    const Matrix squares = z.cwiseAbs2(), products = squares.transpose() * squares / n;
    const Matrix variances = (products - correlations.cwiseAbs2()) / n;
    const double noise = variances.sum() - variances.trace();
    const double signal = correlations.squaredNorm() - correlations.diagonal().squaredNorm();
    const double intensity = signal > 0 ? std::clamp(noise / signal, minIntensity, 1.) : 1;
    correlations *= 1 - intensity;
    correlations.diagonal().setOnes();
    return {sds.asDiagonal() * correlations * sds.asDiagonal(), intensity};
}

double HartlapFactor(double degrees, Eigen::Index dimensions) {
    return std::max(0.05, (degrees - double(dimensions) - 1) / degrees);
}

ResidualLikelihood::ResidualLikelihood(const ShrunkCovariance& covariance, double degrees,
                                       CovarianceError error)
    : precision_(covariance.covariance.llt().solve(
          Matrix::Identity(covariance.covariance.rows(), covariance.covariance.cols()))),
      root_(precision_.llt().matrixL()),
      degrees_(degrees),
      factor_(HartlapFactor(degrees, covariance.covariance.rows())),
      error_(error) {}

double ResidualLikelihood::LogOfMisfit(double misfit, double* slope) const {
    if (error_ == CovarianceError::Hartlap) {
        if (slope) *slope = -0.5 * factor_;
        return -0.5 * factor_ * misfit;
    }
    if (slope) *slope = -0.5 * (degrees_ + 1) / (degrees_ + misfit);
    return -0.5 * (degrees_ + 1) * std::log1p(misfit / degrees_);
}

}  // namespace lacquer::estimate
