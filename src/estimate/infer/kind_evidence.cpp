#include "estimate/infer/kind_evidence.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "estimate/covariance/regression_summaries.h"
#include "estimate/covariance/shrinkage.h"
#include "estimate/emulator/polynomial_basis.h"
#include "estimate/emulator/regression_coordinates.h"
#include "estimate/emulator/runs.h"
#include "estimate/infer/population.h"
#include "estimate/infer/product_target.h"
#include "estimate/random.h"
#include "pbrt/core/check.h"

namespace lacquer::estimate {

namespace {

/// What random numbers are drawn for.
enum Purpose : uint64_t { Simulations, Walks, Proposals };

/// Draws, farther from their mean: simulations have to surround the posterior.
Matrix Widened(const Matrix& draws) {
    constexpr double kWidening = 1.5;  // of the variance
    const Vector mean = draws.rowwise().mean();
    return (std::sqrt(kWidening) * (draws.colwise() - mean)).colwise() + mean;
}

/// What summaries say of the parameters and of the kind.
class KindStatistics {
  public:
    /// @param points  of each kind's simulations, a column for each; `summaries` has their rows one kind
    /// after the other
    KindStatistics(const std::vector<Matrix>& points, const Matrix& summaries)
        : regression_(summaries, TargetsOf(points, summaries.rows())) {}
    Vector Of(const Vector& summaries) const { return regression_.Apply(summaries); }
    /// Of the simulations, by regressions without each: a row for each.
    const Matrix& OfSimulations() const { return regression_.LeftOut(); }

  private:
    static Matrix TargetsOf(const std::vector<Matrix>& points, Eigen::Index count) {
        const Eigen::Index size = points.front().rows();
        // All kinds but one: that it is none of them says that it is the last.
        Matrix targets = Matrix::Zero(count, size + Eigen::Index(points.size()) - 1);
        Eigen::Index row = 0;
        for (size_t k = 0; k < points.size(); ++k) {
            const Eigen::Index rows = points[k].cols();
            targets.block(row, 0, rows, size) = points[k].transpose();
            if (k + 1 < points.size()) targets.block(row, size + Eigen::Index(k), rows, 1).setOnes();
            row += rows;
        }
        return targets;
    }

    RegressionSummaries regression_;
};

/// Posterior density of one kind's logits, given statistics; with what differs between kinds in its constant.
class StatisticsTarget final : public Target {
  public:
    /// @param points      of simulations, a column for each
    /// @param statistics  a row for each
    StatisticsTarget(const ParameterSpace& space, const Matrix& points, const Matrix& statistics,
                     Vector observed)
        : space_(space),
          coordinates_(space),
          observed_(std::move(observed)),
          basis_(points, DegreeFor(points)) {
        basis_.ChooseRidge(statistics);
        coefficients_ = basis_.Fit(statistics);
        const Matrix residuals = statistics - basis_.TermsOfRuns() * coefficients_;
        const double degrees = double(points.cols()) - basis_.NumFree();
        const ShrunkCovariance covariance = ShrinkCorrelations(residuals, degrees);
        likelihood_ = ResidualLikelihood(covariance, degrees, CovarianceError::Student);
        // Of Student's density: by the determinant of the covariance, and by degrees of freedom.
        const auto size = double(observed_.size());
        logConstant_ = std::lgamma((degrees + 1) / 2) - std::lgamma((degrees + 1 - size) / 2) -
                       size / 2 * std::log(degrees) -
                       CholeskyFactor(covariance.covariance).diagonal().array().log().sum();
    }

    Eigen::Index Size() const override { return Eigen::Index(space_.Size()); }
    double LogDensity(const Vector& y, Vector* /*gradient*/) const override {
        const Vector terms = basis_.Terms(basis_.Standardized(coordinates_.FromLogits(y)));
        const double widening = 1 + basis_.Leverage(terms);
        const Vector residual = observed_ - coefficients_.transpose() * terms;
        return likelihood_.LogOfMisfit(likelihood_.Misfit(residual) / widening) + logConstant_ -
               0.5 * double(observed_.size()) * std::log(widening) + space_.LogPriorOfLogit(y);
    }

  private:
    static int DegreeFor(const Matrix& points) {
        return points.cols() >= 3 * Monomials(points.rows(), 2).Size() ? 2 : 1;
    }

    const ParameterSpace& space_;
    RegressionCoordinates coordinates_;
    Vector observed_;
    PolynomialBasis basis_;
    Matrix coefficients_;
    ResidualLikelihood likelihood_;
    double logConstant_;  ///< what differs between kinds
};

/// Logarithm of the integral of a target's density, by importance sampling from a t distribution with the
/// mean and the covariance of draws.
double LogIntegral(const Target& target, const Matrix& draws, uint64_t seed) {
    constexpr Eigen::Index kProposals = 8000;
    constexpr double kDegrees = 6;
    const Vector mean = draws.rowwise().mean();
    const Matrix root = CholeskyFactor(CovarianceOfColumns(draws));
    const auto size = double(mean.size());
    Vector logWeights(kProposals);
    for (Eigen::Index i = 0; i < kProposals; ++i) {
        Random random(seed, Proposals, uint64_t(i));
        const Vector z = random.Normals(mean.size());
        // A sum of as many squares has a chi-squared distribution.
        const double scale = std::sqrt(random.Normals(Eigen::Index(kDegrees)).squaredNorm() / kDegrees);
        const Vector u = z / scale;
        const double value = target.LogDensity(mean + root * u, nullptr);
        logWeights[i] = std::isnan(value)
                            ? -std::numeric_limits<double>::infinity()
                            : value + 0.5 * (kDegrees + size) * std::log1p(u.squaredNorm() / kDegrees);
    }
    const double largest = logWeights.maxCoeff();
    return largest + std::log((logWeights.array() - largest).exp().mean()) +
           root.diagonal().array().log().sum();
}

/// In coordinates in which products are straight.
double LogEvidence(const ParameterSpace& space, const Target& ofLogits, const Matrix& starts, uint64_t seed) {
    constexpr Eigen::Index kWalks = 80;
    constexpr uint64_t kSteps = 300;
    const ProductTarget target(space, ofLogits);
    const PopulationWalk walk({.seed = Hash(seed, uint64_t(Walks)), .windowSteps = kSteps / 5});
    PopulationState state = walk.Start(target, target.FromLogits(ThinnedColumns(starts, kWalks)));
    walk.Warmup(target, &state);
    return LogIntegral(target, walk.Sample(target, kSteps, &state).y, seed);
}

}  // namespace

std::vector<double> KindProbabilities(const std::vector<KindPosterior>& kinds, const Vector& observed,
                                      Eigen::Index runs, uint64_t seed, Observer* observer) {
    if (kinds.size() == 1) return {1};
    const ParameterSpace& space = kinds.front().simulator->Parameters();
    const RegressionCoordinates coordinates(space);
    const auto count = Eigen::Index(kinds.size());
    std::vector<Matrix> points;
    Matrix summaries(count * runs, observed.size());
    for (Eigen::Index k = 0; k < count; ++k) {
        const KindPosterior& kind = kinds[size_t(k)];
        const Runs made = RunSimulator(*kind.simulator, Widened(ThinnedColumns(kind.draws, runs)),
                                       Hash(seed, Simulations, uint64_t(k)), nullptr, observer);
        points.push_back(coordinates.FromLogits(made.parameters));
        summaries.middleRows(k * runs, runs) = made.summaries;
    }
    const KindStatistics statistics(points, summaries);
    Vector logEvidence(count);
    for (Eigen::Index k = 0; k < count; ++k) {
        const StatisticsTarget target(space, points[size_t(k)],
                                      statistics.OfSimulations().middleRows(k * runs, runs),
                                      statistics.Of(observed));
        logEvidence[k] = LogEvidence(space, target, kinds[size_t(k)].draws, Hash(seed, uint64_t(k)));
    }
    LACQUER_CHECK(logEvidence.allFinite());
    Vector probabilities = (logEvidence.array() - logEvidence.maxCoeff()).exp().matrix();
    probabilities /= probabilities.sum();
    return {probabilities.begin(), probabilities.end()};
}

}  // namespace lacquer::estimate
