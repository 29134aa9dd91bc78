#include "estimate/emulator/summary_emulator.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "estimate/infer/population.h"
#include "pbrt/core/check.h"

namespace lacquer::estimate {

namespace {

/// Inverse of B^T B, with a ridge far below what data tell.
Matrix InverseGram(const Matrix& basis) {
    Matrix gram = basis.transpose() * basis;
    gram.diagonal().array() += 1e-10 * gram.trace() / double(gram.rows());
    return gram.ldlt().solve(Matrix::Identity(gram.rows(), gram.cols()));
}

/// Logarithms of variances change by at most this from the centre of the simulations.
constexpr double kMaxLogVariance = 8;

/// Slope and value of the logarithm of a variance relative to the centre, limited smoothly.
double Limited(double z, double* slope) {
    const double limited = kMaxLogVariance * std::tanh(z / kMaxLogVariance);
    if (slope) *slope = 1 - limited * limited / (kMaxLogVariance * kMaxLogVariance);
    return limited;
}

}  // namespace

SummaryEmulator::SummaryEmulator(const Matrix& parameters, const Matrix& summaries, const Options& options)
    : options_(options),
      center_(parameters.rowwise().mean()),
      whitening_(CholeskyFactor(CovarianceOfColumns(parameters))
                     .triangularView<Eigen::Lower>()
                     .solve(Matrix::Identity(parameters.rows(), parameters.rows()))),
      projection_(summaries),
      monomials_(parameters.rows(), options.degree) {
    const Eigen::Index count = parameters.cols(), size = parameters.rows();
    LACQUER_CHECK(summaries.rows() == count && count >= monomials_.Size() + 10);
    Matrix basis(count, monomials_.Size()), design(count, size + 1);
    for (Eigen::Index i = 0; i < count; ++i) {
        const Vector t = Standardized(parameters.col(i));
        basis.row(i) = monomials_.At(t);
        design.row(i) << 1, t.transpose();
    }
    const Matrix values = projection_.ApplyToRows(summaries);
    inverseGram_ = InverseGram(basis);
    const Vector leverages = (basis * inverseGram_).cwiseProduct(basis).rowwise().sum();
    logVariances_ = Matrix::Zero(size + 1, values.cols());
    // Twice: variances weigh the means' regression, whose residuals give the variances.
    for (int round = 0; round < 2; ++round) {
        FitMeans(basis, design, values);
        FitVariances(design, leverages, values - basis * coefficients_);
    }
    const Matrix residuals = values - basis * coefficients_;
    Matrix scaled = residuals;
    for (Eigen::Index i = 0; i < count; ++i)
        for (Eigen::Index j = 0; j < scaled.cols(); ++j)
            scaled(i, j) *= std::exp(
                -0.5 * (logVariances_(0, j) +
                        Limited(logVariances_.col(j).tail(size).dot(design.row(i).tail(size).transpose()),
                                nullptr)));
    const auto degrees = double(count - monomials_.Size());
    likelihood_ = ResidualLikelihood(ShrinkCorrelations(scaled, degrees), degrees, options.covarianceError);
}

void SummaryEmulator::FitMeans(const Matrix& basis, const Matrix& design, const Matrix& values) {
    if (logVariances_.isZero()) {
        coefficients_ = inverseGram_ * (basis.transpose() * values);
        return;
    }
    const Eigen::Index size = design.cols() - 1;
    for (Eigen::Index j = 0; j < values.cols(); ++j) {
        Vector roots(basis.rows());
        for (Eigen::Index i = 0; i < basis.rows(); ++i)
            roots[i] = std::exp(
                -0.5 *
                Limited(logVariances_.col(j).tail(size).dot(design.row(i).tail(size).transpose()), nullptr));
        const Matrix weighted = roots.asDiagonal() * basis;
        Matrix gram = weighted.transpose() * weighted;
        gram.diagonal().array() += 1e-10 * gram.trace() / double(gram.rows());
        coefficients_.col(j) = gram.ldlt().solve(weighted.transpose() * roots.cwiseProduct(values.col(j)));
    }
}

void SummaryEmulator::FitVariances(const Matrix& design, const Vector& leverages, const Matrix& residuals) {
    const Eigen::Index count = design.rows(), size = design.cols() - 1;
    // A fitted residual is smaller than the one that it stands for.
    const Matrix squares =
        (1 - leverages.array()).max(0.1).inverse().matrix().asDiagonal() * residuals.cwiseAbs2();
    for (Eigen::Index j = 0; j < residuals.cols(); ++j) {
        Vector beta = Vector::Zero(size + 1);
        beta[0] = std::log(squares.col(j).mean() + 1e-24);
        // Fisher's scoring of normal residuals; a ridge of 30 simulations pulls slopes to zero.
        for (int step = 0; options_.hasVaryingVariance && step < 6; ++step) {
            const Vector raw = design.rightCols(size) * beta.tail(size);
            Matrix effects = design;
            Vector excess(count);
            for (Eigen::Index i = 0; i < count; ++i) {
                double slope = 1;
                const double value = beta[0] + Limited(raw[i], &slope);
                effects.row(i).tail(size) *= slope;
                // Large residuals count less than their squares: they must not make the slopes alone.
                excess[i] = std::min(squares(i, j) * std::exp(-value), 9.) - 1;
            }
            Vector score = effects.transpose() * excess;
            Matrix information = effects.transpose() * effects;
            information.diagonal().tail(size).array() += 30;
            score.tail(size) -= 30 * beta.tail(size);
            beta += information.ldlt().solve(score);
        }
        logVariances_.col(j) = beta;
    }
}

Vector SummaryEmulator::StandardizedResidual(const Vector& y, const Vector& projected) const {
    const Vector t = Standardized(y);
    Vector residual = projected - coefficients_.transpose() * monomials_.At(t);
    for (Eigen::Index j = 0; j < residual.size(); ++j)
        residual[j] *= std::exp(
            -0.5 * (logVariances_(0, j) + Limited(logVariances_.col(j).tail(t.size()).dot(t), nullptr)));
    return residual;
}

double SummaryEmulator::Misfit(const Vector& y, const Vector& projected) const {
    const Vector terms = monomials_.At(Standardized(y));
    return likelihood_.Misfit(StandardizedResidual(y, projected)) / (1 + terms.dot(inverseGram_ * terms));
}

double SummaryEmulator::LogLikelihood(const Vector& y, const Vector& projected, Vector* gradient,
                                      double inflation) const {
    const Vector t = Standardized(y), terms = monomials_.At(t);
    const Vector gramTerms = inflation * (inverseGram_ * terms);
    const double widening = inflation + terms.dot(gramTerms);
    const auto size = double(projected.size());
    Vector inverseSds(projected.size()), slopes(projected.size());
    double logSds = 0;
    for (Eigen::Index j = 0; j < projected.size(); ++j) {
        const double change = Limited(logVariances_.col(j).tail(t.size()).dot(t), &slopes[j]);
        inverseSds[j] = std::exp(-0.5 * (logVariances_(0, j) + change));
        logSds += 0.5 * change;
    }
    const Vector u = (coefficients_.transpose() * terms - projected).cwiseProduct(inverseSds);
    const Vector weighted = likelihood_.Weighted(u);
    const double misfit = u.dot(weighted) / widening;
    double slope = 0;
    const double value = likelihood_.LogOfMisfit(misfit, &slope) - logSds - 0.5 * size * std::log(widening);
    if (gradient) {
        // Of the misfit by way of the means and of the widening, and of the determinant by way of the latter.
        const Vector byTerms = 2 * slope / widening * (coefficients_ * weighted.cwiseProduct(inverseSds)) -
                               (2 * slope * misfit + size) / widening * gramTerms;
        Vector inT = monomials_.Gradient(t, byTerms);
        // By way of the variances: u changes by -u/2 for each logarithm.
        const Vector byVariances =
            (-slope / widening * u.cwiseProduct(weighted).array() - 0.5).matrix().cwiseProduct(slopes);
        inT += logVariances_.bottomRows(t.size()) * byVariances;
        *gradient = whitening_.transpose() * inT;
    }
    return value;
}

}  // namespace lacquer::estimate
