#include "estimate/layered/lobe_likelihood.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "pbrt/core/check.h"

namespace lacquer::estimate {

LobeLikelihood::LobeLikelihood(Vector observed, const Vector& deviations, PredictionError error,
                               bool isRobust)
    : observed_(std::move(observed)),
      variances_(deviations.cwiseAbs2() + error.independent),
      common_(std::move(error.common)),
      allVariances_(variances_),
      isRobust_(isRobust) {
    LACQUER_CHECK(variances_.size() == observed_.size());
    if (common_.cols() > 0) allVariances_ += common_.rowwise().squaredNorm();
}

double LobeLikelihood::Log(const Vector& mean, double noise, Vector* byMean, double* byNoise) const {
    const Vector residual = observed_ - mean;
    return isRobust_ ? LogOfStudent(residual, noise, byMean, byNoise)
                     : LogOfNormal(residual, noise, byMean, byNoise);
}

// With C = N + W W^T, N diagonal: C^-1 = N^-1 - N^-1 W A^-1 W^T N^-1, det C = det N det A, A = 1 + W^T N^-1
// W.
double LobeLikelihood::LogOfNormal(const Vector& residual, double noise, Vector* byMean,
                                   double* byNoise) const {
    const Vector n = (variances_.array() + noise * noise).matrix(), inverse = n.cwiseInverse();
    const Matrix scaled = inverse.asDiagonal() * common_;
    const Eigen::LLT<Matrix> a(Matrix::Identity(common_.cols(), common_.cols()) +
                               common_.transpose() * scaled);
    const Vector weighted = residual.cwiseProduct(inverse) - scaled * a.solve(scaled.transpose() * residual);
    const double logDeterminant =
        n.array().log().sum() + 2 * Matrix(a.matrixL()).diagonal().array().log().sum();
    if (byMean) *byMean = weighted;
    if (byNoise) {
        const Matrix half = a.matrixL().solve(scaled.transpose());  // columns: values
        const double trace = inverse.sum() - half.squaredNorm();
        *byNoise = noise * (weighted.squaredNorm() - trace);
    }
    return -0.5 * (logDeterminant + residual.dot(weighted));
}

double LobeLikelihood::LogOfStudent(const Vector& residual, double noise, Vector* byMean,
                                    double* byNoise) const {
    const Eigen::ArrayXd scale = allVariances_.array() + noise * noise;
    const Eigen::ArrayXd ratio = residual.array().square() / scale;
    const Eigen::ArrayXd pull = (kDegrees + 1) / (kDegrees + ratio);  // of normal residuals: 1
    if (byMean) *byMean = (pull * residual.array() / scale).matrix();
    if (byNoise) *byNoise = noise * ((pull * ratio - 1) / scale).sum();
    return (-0.5 * scale.log() - 0.5 * (kDegrees + 1) * (1 + ratio / kDegrees).log()).sum();
}

double LobeLikelihood::Misfit(const Vector& mean, double noise) const {
    return ((observed_ - mean).array().square() / (allVariances_.array() + noise * noise)).mean();
}

}  // namespace lacquer::estimate
