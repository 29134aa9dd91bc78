#include "estimate/diagnostics/family_information.h"

#include <Eigen/Cholesky>

#include "estimate/covariance/projection.h"
#include "estimate/covariance/shrinkage.h"
#include "estimate/random.h"
#include "pbrt/core/parallel.h"

namespace lacquer::estimate {

namespace {

/// Variances of the prior, in logits.
Vector PriorVariances(const ParameterSpace& space, uint64_t seed) {
    constexpr int kDraws = 2000;
    Matrix draws(Eigen::Index(space.Size()), kDraws);
    for (int k = 0; k < kDraws; ++k) {
        Random random(seed, k);
        draws.col(k) = space.ToLogit(space.SamplePrior(random));
    }
    return (draws.colwise() - draws.rowwise().mean()).rowwise().squaredNorm() / (kDraws - 1);
}

/// Derivatives of the means by logits: a column for each parameter.
Matrix MeanDerivatives(const Simulator& simulator, const Vector& y, Eigen::Index numSummaries,
                       uint64_t seed) {
    // Wide enough for maps that move by texels; the scatter that common seeds leave falls with it.
    constexpr double kStep = 0.1;
    constexpr Eigen::Index kSeeds = 16;
    Matrix derivatives = Matrix::Zero(numSummaries, y.size());
    for (Eigen::Index i = 0; i < y.size(); ++i) {
        Matrix differences(numSummaries, kSeeds);
        ParallelFor(kSeeds, [&](int64_t k) {
            const auto at = [&](double step) {
                Vector moved = y;
                moved[i] += step;
                return simulator.Simulate(simulator.Parameters().ToNatural(moved), Hash(seed, uint64_t(k)));
            };
            differences.col(k) = (at(kStep) - at(-kStep)) / (2 * kStep);
        });
        derivatives.col(i) = differences.rowwise().mean();
    }
    return derivatives;
}

}  // namespace

Matrix PredictedDeviations(const Simulator& simulator, const std::vector<FamilyRange>& families,
                           const Vector& y, Eigen::Index runs, uint64_t seed) {
    const auto numSummaries = Eigen::Index(simulator.SummaryNames().size());
    const Vector x = simulator.Parameters().ToNatural(y);
    Matrix summaries(runs, numSummaries);
    ParallelFor(runs,
                [&](int64_t i) { summaries.row(i) = simulator.Simulate(x, Hash(seed, 1, uint64_t(i))); });
    const Matrix derivatives = MeanDerivatives(simulator, y, numSummaries, Hash(seed, 2));
    const Vector prior = PriorVariances(simulator.Parameters(), Hash(seed, 3));
    std::vector<FamilyRange> wanted = families;
    wanted.push_back({"all", 0, numSummaries});
    Matrix deviations(Eigen::Index(wanted.size()), y.size());
    for (size_t f = 0; f < wanted.size(); ++f) {
        const Matrix own = summaries.middleCols(wanted[f].first, wanted[f].count);
        const SummaryProjection projection(own);
        const Matrix projected = projection.ApplyToRows(own);
        const auto degrees = double(runs - 1);
        const ShrunkCovariance scatter =
            ShrinkCorrelations(projected.rowwise() - projected.colwise().mean(), degrees);
        // Differences of projected summaries are projections of differences, up to the mean.
        const Vector zero = projection.Apply(Vector::Zero(wanted[f].count));
        Matrix slopes(projection.Size(), y.size());
        for (Eigen::Index i = 0; i < y.size(); ++i)
            slopes.col(i) =
                projection.Apply(derivatives.col(i).segment(wanted[f].first, wanted[f].count)) - zero;
        Matrix information = HartlapFactor(degrees, projection.Size()) * slopes.transpose() *
                             scatter.covariance.llt().solve(slopes);
        information.diagonal() += prior.cwiseInverse();
        const Matrix covariance = information.llt().solve(Matrix::Identity(y.size(), y.size()));
        deviations.row(Eigen::Index(f)) = covariance.diagonal().cwiseQuotient(prior).cwiseSqrt();
    }
    return deviations;
}

}  // namespace lacquer::estimate
