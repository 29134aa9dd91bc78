#include "estimate/emulator/summary_emulator.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

namespace lacquer::estimate {

namespace {

/// Logarithms of variances change by at most this from the centre of the simulations.
constexpr double kMaxLogVariance = 4;

/// Up to so many summaries for each parameter are taken as they are.
constexpr Eigen::Index kMaxOwn = 3;

/// Part of the simulations within which the polynomials are taken at their word.
constexpr double kInside = 0.98;

/// Slope and value of the logarithm of a variance relative to the centre, limited smoothly.
double Limited(double z, double* slope) {
    const double limited = kMaxLogVariance * std::tanh(z / kMaxLogVariance);
    if (slope) *slope = 1 - limited * limited / (kMaxLogVariance * kMaxLogVariance);
    return limited;
}

}  // namespace

SummaryEmulator::SummaryEmulator(const Matrix& parameters, const Matrix& summaries, const Options& options)
    : options_(options), basis_(parameters, options.degree) {
    const Matrix runs = basis_.StandardizedRuns(parameters);
    std::vector<double> distances(size_t(runs.rows()));
    Eigen::Map<Vector>(distances.data(), runs.rows()) = runs.rowwise().squaredNorm();
    const auto outer = distances.begin() + std::ptrdiff_t(kInside * double(distances.size()));
    std::nth_element(distances.begin(), outer, distances.end());
    squaredRadius_ = *outer;
    regression_ = summaries.cols() <= kMaxOwn * runs.cols() ? RegressionSummaries(summaries)
                                                            : RegressionSummaries(summaries, runs);
    const Matrix& values = regression_.LeftOut();
    basis_.ChooseRidge(values);
    logVariances_ = Matrix::Zero(runs.cols() + 1, values.cols());
    // Twice: variances weigh the means' regression, whose residuals give the variances.
    for (int round = 0; round < 2; ++round) {
        FitMeans(runs, values);
        FitVariances(runs, values - basis_.TermsOfRuns() * coefficients_);
    }
    const Matrix scaled = (values - basis_.TermsOfRuns() * coefficients_).cwiseQuotient(DeviationsAt(runs));
    const double degrees = double(runs.rows()) - basis_.NumFree();
    likelihood_ = ResidualLikelihood(ShrinkCorrelations(scaled, degrees), degrees, options.covarianceError);
}

Matrix SummaryEmulator::DeviationsAt(const Matrix& runs) const {
    Matrix changes = runs * logVariances_.bottomRows(runs.cols());
    for (double& change : changes.reshaped()) change = Limited(change, nullptr);
    return (0.5 * (changes.rowwise() + logVariances_.row(0))).array().exp();
}

void SummaryEmulator::FitMeans(const Matrix& runs, const Matrix& values) {
    if (!options_.hasVaryingVariance || logVariances_.isZero()) {
        coefficients_ = basis_.Fit(values);
        return;
    }
    const Matrix weights = DeviationsAt(runs).cwiseAbs2().cwiseInverse();
    for (Eigen::Index j = 0; j < values.cols(); ++j)
        coefficients_.col(j) = basis_.FitWeighted(values.col(j), weights.col(j));
}

void SummaryEmulator::FitVariances(const Matrix& runs, const Matrix& residuals) {
    const Eigen::Index count = runs.rows(), size = runs.cols();
    Matrix design(count, size + 1);
    design << Vector::Ones(count), runs;
    const Vector leverages = basis_.Leverages();
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

double SummaryEmulator::LogLikelihood(const Vector& y, const Vector& projected, Vector* gradient,
                                      double inflation) const {
    const Vector t = basis_.Standardized(y), terms = basis_.Terms(t);
    const Vector gramTerms = inflation * (basis_.InverseGram() * terms);
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
    const double outside = std::max(0., t.squaredNorm() - squaredRadius_);
    const double value =
        likelihood_.LogOfMisfit(misfit, &slope) - logSds - 0.5 * size * std::log(widening) - 0.5 * outside;
    if (gradient) {
        // Of the misfit by way of the means and of the widening, and of the determinant by way of the latter.
        const Vector byTerms = 2 * slope / widening * (coefficients_ * weighted.cwiseProduct(inverseSds)) -
                               (2 * slope * misfit + size) / widening * gramTerms;
        // By way of the variances: u changes by -u/2 for each logarithm.
        const Vector byVariances =
            (-slope / widening * u.cwiseProduct(weighted).array() - 0.5).matrix().cwiseProduct(slopes);
        *gradient =
            basis_.Gradient(t, byTerms) + basis_.ToOriginal(logVariances_.bottomRows(t.size()) * byVariances -
                                                            (outside > 0 ? t : Vector::Zero(t.size())));
    }
    return value;
}

}  // namespace lacquer::estimate
