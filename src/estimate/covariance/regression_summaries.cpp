#include "estimate/covariance/regression_summaries.h"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

namespace lacquer::estimate {

namespace {

/// Predictions of a ridge regression for rows that it was made without, in closed form [Allen 1974].
/// @param rotated  rows of summaries in the eigenvectors of their Gram matrix
/// @param gains    1 / (eigenvalue + ridge)
Vector LeaveOneOut(const Matrix& rotated, const Vector& values, const Vector& gains) {
    const auto count = double(values.size());
    const Vector coefficients = gains.cwiseProduct(rotated.transpose() * values);
    // Leverages; 1 / count is that of the mean, which has been subtracted.
    const Vector leverages = (rotated.cwiseAbs2() * gains).array() + 1 / count;
    return ((rotated * coefficients - leverages.cwiseProduct(values)).array() /
            (1 - leverages.array()).max(1e-3))
        .matrix();
}

}  // namespace

Matrix RegressionSummaries::Standardize(const Matrix& summaries) {
    means_ = summaries.colwise().mean();
    const Matrix centered = summaries.rowwise() - means_.transpose();
    const Vector sds = (centered.colwise().squaredNorm() / double(summaries.rows())).cwiseSqrt();
    // Below this, a summary is constant but for the rounding of its own sum.
    const Vector least = 1e-9 * means_.cwiseAbs().array() + 1e-12;
    inverseSds_ = (sds.array() > least.array()).select(sds.array().inverse(), 0.).matrix();
    return centered * inverseSds_.asDiagonal();
}

RegressionSummaries::RegressionSummaries(const Matrix& summaries)
    : weights_(Matrix::Identity(summaries.cols(), summaries.cols())), leftOut_(Standardize(summaries)) {}

RegressionSummaries::RegressionSummaries(const Matrix& summaries, const Matrix& parameters)
    : weights_(summaries.cols(), parameters.cols()), leftOut_(parameters.rows(), parameters.cols()) {
    const auto count = double(summaries.rows());
    const Matrix z = Standardize(summaries);
    const Eigen::SelfAdjointEigenSolver<Matrix> solver(z.transpose() * z);
    const Vector eigenvalues = solver.eigenvalues().cwiseMax(0.);
    const Matrix rotated = z * solver.eigenvectors();
    for (Eigen::Index k = 0; k < parameters.cols(); ++k) {
        const Vector values = parameters.col(k).array() - parameters.col(k).mean();
        double best = std::numeric_limits<double>::infinity(), leverage = 0;
        for (double ridge = 1e-7 * count; ridge < 3 * count; ridge *= std::sqrt(10.)) {
            const Vector gains = (eigenvalues.array() + ridge).inverse();
            const Vector predicted = LeaveOneOut(rotated, values, gains);
            const double error = (values - predicted).squaredNorm();
            if (!(error < best)) continue;
            best = error;
            leverage = eigenvalues.cwiseProduct(gains).sum() / count;
            leftOut_.col(k) = predicted;
            weights_.col(k) = solver.eigenvectors() * gains.cwiseProduct(rotated.transpose() * values);
        }
        leverage_ += leverage / double(parameters.cols());
    }
}

}  // namespace lacquer::estimate
