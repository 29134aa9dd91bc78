#include "estimate/emulator/model_check.h"

#include <Eigen/Cholesky>

namespace lacquer::estimate {

namespace {

/// Summaries that agree better than this says differ by scatter that is not the same everywhere in the region
/// of the simulations, columns on both sides of the middle of a photograph for example: such differences
/// decide nothing here.
constexpr double kMinIntensity = 0.05;

}  // namespace

ModelCheck::ModelCheck(const Matrix& parameters, const Matrix& summaries, int degree)
    : basis_(parameters, degree), projection_(summaries) {
    const Matrix values = projection_.ApplyToRows(summaries);
    basis_.ChooseRidge(values);
    coefficients_ = basis_.Fit(values);
    residuals_ = values - basis_.TermsOfRuns() * coefficients_;
}

double ModelCheck::Misfit(const Matrix& draws, const Vector& summaries) const {
    Matrix predicted(draws.cols(), NumSummaries());
    double leverage = 0;
    for (Eigen::Index i = 0; i < draws.cols(); ++i) {
        const Vector terms = basis_.Terms(basis_.Standardized(draws.col(i)));
        predicted.row(i) = terms.transpose() * coefficients_;
        leverage += basis_.Leverage(terms) / double(draws.cols());
    }
    const double degrees = double(residuals_.rows()) - basis_.NumFree();
    Matrix covariance = (1 + leverage) * ShrinkCorrelations(residuals_, degrees, kMinIntensity).covariance;
    const Vector mean = predicted.colwise().mean();
    predicted.rowwise() -= mean.transpose();
    covariance += predicted.transpose() * predicted / double(draws.cols());
    const Vector residual = projection_.Apply(summaries) - mean;
    return residual.dot(covariance.llt().solve(residual)) / double(NumSummaries());
}

}  // namespace lacquer::estimate
