#include "estimate/infer/population.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "estimate/diagnostics/convergence.h"
#include "estimate/random.h"
#include "pbrt/core/check.h"
#include "pbrt/core/parallel.h"

namespace lacquer::estimate {

Matrix ThinnedColumns(const Matrix& columns, Eigen::Index count) {
    LACQUER_CHECK(columns.cols() >= count && count > 0);
    Matrix thinned(columns.rows(), count);
    for (Eigen::Index i = 0; i < count; ++i)
        thinned.col(i) = columns.col((2 * i + 1) * columns.cols() / (2 * count));
    return thinned;
}

Matrix CovarianceOfColumns(const Matrix& columns) {
    const Matrix centered = columns.colwise() - columns.rowwise().mean();
    return centered * centered.transpose() / double(std::max<Eigen::Index>(1, columns.cols() - 1));
}

Matrix CholeskyFactor(const Matrix& covariance) {
    const Eigen::Index n = covariance.rows();
    const double ridge = 1e-9 * std::max(covariance.trace() / double(n), 1e-300);
    return Eigen::LLT<Matrix>(covariance + ridge * Matrix::Identity(n, n)).matrixL();
}

Matrix PopulationDraws::Coordinate(Eigen::Index i) const {
    return y.row(i).reshaped(numWalks, y.cols() / numWalks).transpose();
}

double MaxRhat(const PopulationDraws& draws) {
    double most = 0;
    for (Eigen::Index i = 0; i < draws.y.rows(); ++i) most = std::max(most, SplitRhat(draws.Coordinate(i)));
    return most;
}

PopulationState PopulationWalk::Start(const Target& target, const Matrix& starts) const {
    LACQUER_CHECK(starts.cols() > starts.rows());
    PopulationState state;
    state.walks = starts;
    state.logDensities.resize(starts.cols());
    ParallelFor(starts.cols(),
                [&](int64_t w) { state.logDensities[w] = target.LogDensity(starts.col(w), nullptr); });
    state.covariance = CovarianceOfColumns(starts);
    // The best scale for normal targets [Roberts and Rosenthal 2009], a little shorter.
    state.logScale = std::log(2.38 * std::sqrt(0.7 / double(starts.rows())));
    return state;
}

PopulationDraws PopulationWalk::Walk(const Target& target, uint64_t numSteps, PopulationState* state) const {
    const Eigen::Index numWalks = state->walks.cols();
    const Matrix proposal = std::exp(state->logScale) * CholeskyFactor(state->covariance);
    PopulationDraws draws{Matrix(state->walks.rows(), Eigen::Index(numSteps) * numWalks),
                          Vector(Eigen::Index(numSteps) * numWalks), numWalks};
    Vector accepted = Vector::Zero(numWalks);
    ParallelFor(numWalks, [&](int64_t walk) {
        Vector y = state->walks.col(walk);
        double logDensity = state->logDensities[walk];
        for (uint64_t i = 0; i < numSteps; ++i) {
            Random random(options_.seed, uint64_t(walk), state->step + i);
            const Vector proposed = y + proposal * random.Normals(y.size());
            const double there = target.LogDensity(proposed, nullptr);
            if (std::log(random.Uniform()) < there - logDensity) {  // false for NaN
                y = proposed;
                logDensity = there;
                ++accepted[walk];
            }
            const Eigen::Index column = Eigen::Index(i) * numWalks + walk;
            draws.y.col(column) = y;
            draws.logDensities[column] = logDensity;
        }
        state->walks.col(walk) = y;
        state->logDensities[walk] = logDensity;
    });
    state->step += numSteps;
    state->acceptance = accepted.sum() / double(numWalks) / double(numSteps);
    return draws;
}

void PopulationWalk::Warmup(const Target& target, PopulationState* state) const {
    for (; state->numWindows < options_.numWindows; ++state->numWindows) {
        const PopulationDraws draws = Walk(target, options_.windowSteps, state);
        state->covariance = CovarianceOfColumns(draws.y.rightCols((draws.y.cols() + 1) / 2));
        state->logScale += 1.5 * (state->acceptance - 0.25);
    }
}

PopulationDraws PopulationWalk::Sample(const Target& target, uint64_t numSteps,
                                       PopulationState* state) const {
    return Walk(target, numSteps, state);
}

}  // namespace lacquer::estimate
