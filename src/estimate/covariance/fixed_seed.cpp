#include "estimate/covariance/fixed_seed.h"

#include <cmath>

#include "pbrt/core/check.h"
#include "pbrt/core/parallel.h"
#include "pbrt/core/rng.h"

namespace lacquer::estimate {

SummaryScatter MeasureScatter(const Simulator& simulator, const Vector& x, Eigen::Index numRuns,
                              uint64_t seed) {
    Matrix summaries(numRuns, Eigen::Index(simulator.SummaryNames().size()));
    ParallelFor(numRuns,
                [&](int64_t i) { summaries.row(i) = simulator.Simulate(x, Hash(seed, uint64_t(i))); });
    SummaryScatter scatter{.projection = SummaryProjection(summaries), .covariance = {}};
    const Matrix projected = scatter.projection.ApplyToRows(summaries);
    scatter.degrees = double(numRuns - 1);
    scatter.covariance =
        ShrinkCorrelations(projected.rowwise() - projected.colwise().mean(), scatter.degrees);
    return scatter;
}

SummaryScatter ScatterByHand(Eigen::Index numSummaries, double error) {
    constexpr double kCertain = 1e12;  // degrees of freedom of a covariance that is known
    const double unit = error * std::sqrt(double(numSummaries));
    return {.projection = SummaryProjection::WithUnits(Vector::Constant(numSummaries, unit)),
            .covariance = {Matrix::Identity(numSummaries, numSummaries), 0},
            .degrees = kCertain};
}

FixedSeedTarget::FixedSeedTarget(const Simulator& simulator, const Vector& observed,
                                 const SummaryScatter& scatter, Options options)
    : simulator_(simulator),
      projection_(scatter.projection),
      likelihood_(scatter.covariance, scatter.degrees, options.covarianceError),
      projected_(projection_.Apply(observed)),
      options_(std::move(options)),
      inflation_((options_.countsOwnScatter ? 1 + 1 / double(options_.seeds.size()) : 1) * options_.tau *
                 options_.tau) {
    LACQUER_CHECK(!options_.seeds.empty());
}

bool FixedSeedTarget::HasGradient() const {
    const ParameterSpace& space = simulator_.Parameters();
    return simulator_.SimulateForGradient(space.ToNatural(Vector::Zero(Size())), options_.seeds[0]) !=
           nullptr;
}

Vector FixedSeedTarget::Residual(const Vector& y) const {
    const Vector x = simulator_.Parameters().ToNatural(y);
    Matrix summaries(Eigen::Index(simulator_.SummaryNames().size()), Eigen::Index(options_.seeds.size()));
    ParallelFor(summaries.cols(),
                [&](int64_t k) { summaries.col(k) = simulator_.Simulate(x, options_.seeds[size_t(k)]); });
    return projection_.Apply(summaries.rowwise().mean()) - projected_;
}

double FixedSeedTarget::Misfit(const Vector& y) const { return likelihood_.Misfit(Residual(y)) / inflation_; }

double FixedSeedTarget::LogLikelihood(const Vector& y, Vector* gradient) const {
    if (!gradient) return likelihood_.LogOfMisfit(Misfit(y));
    const Vector x = simulator_.Parameters().ToNatural(y);
    const size_t numSeeds = options_.seeds.size();
    std::vector<std::unique_ptr<DifferentiableRun>> runs(numSeeds);
    ParallelFor(int64_t(numSeeds), [&](int64_t k) {
        runs[size_t(k)] = simulator_.SimulateForGradient(x, options_.seeds[size_t(k)]);
    });
    Vector mean = Vector::Zero(Eigen::Index(simulator_.SummaryNames().size()));
    for (const auto& run : runs) {
        LACQUER_CHECK(run != nullptr);
        mean += run->Summaries() / double(numSeeds);
    }
    const Vector residual = projection_.Apply(mean) - projected_;
    double slope = 0;
    const double value = likelihood_.LogOfMisfit(likelihood_.Misfit(residual) / inflation_, &slope);
    const Vector adjoint =
        projection_.ApplyTransposed(2 * slope / inflation_ * likelihood_.Weighted(residual)) /
        double(numSeeds);
    Matrix gradients(y.size(), Eigen::Index(numSeeds));
    ParallelFor(int64_t(numSeeds), [&](int64_t k) { gradients.col(k) = runs[size_t(k)]->Gradient(adjoint); });
    *gradient = gradients.rowwise().sum().cwiseProduct(simulator_.Parameters().Slopes(y));
    return value;
}

double FixedSeedTarget::LogDensity(const Vector& y, Vector* gradient) const {
    // Beyond this, parameters are at their bounds to the last bit.
    if (!(y.cwiseAbs().maxCoeff() < 30)) return -std::numeric_limits<double>::infinity();
    Vector ofPrior;
    const double prior = simulator_.Parameters().LogPriorOfLogit(y, gradient ? &ofPrior : nullptr);
    const double value = LogLikelihood(y, gradient) + prior;
    if (gradient) *gradient += ofPrior;
    return value;
}

double FixedSeedTarget::Energy(const Vector& y, Vector* gradient) const {
    const ParameterSpace& space = simulator_.Parameters();
    Vector ofPrior;
    const double prior = space.LogPrior(space.ToNatural(y), gradient ? &ofPrior : nullptr);
    const double value = LogLikelihood(y, gradient) + prior;
    if (gradient) *gradient = -*gradient - ofPrior.cwiseProduct(space.Slopes(y));
    return -value;
}

Vector FixedSeedTarget::Residuals(const Vector& y) const {
    const ParameterSpace& space = simulator_.Parameters();
    const Vector x = space.ToNatural(y);
    Vector residuals(NumSummaries() + Size());
    residuals.head(NumSummaries()) = likelihood_.Whitened(Residual(y)) / std::sqrt(inflation_);
    for (Eigen::Index i = 0; i < Size(); ++i)
        residuals[NumSummaries() + i] = (x[i] - space[size_t(i)].prior.mean) / space[size_t(i)].prior.sd;
    return residuals;
}

}  // namespace lacquer::estimate
