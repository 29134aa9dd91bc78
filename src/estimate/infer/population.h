// A population of random walks with a common proposal: for targets without gradients, or with surfaces too
// rugged for them.
#pragma once

#include "estimate/infer/target.h"
#include "pbrt/core/progress.h"

namespace lacquer::estimate {

/// All walks of a population, between two windows of warm-up or after it.
struct PopulationState {
    uint64_t step = 0;    ///< steps done by each walk
    int numWindows = 0;   ///< windows of warm-up done
    Matrix walks;         ///< a column for each
    Vector logDensities;  ///< of the columns
    Matrix covariance;    ///< of the proposals, times scale^2
    double logScale = 0;
    double acceptance = 0;  ///< of the last window, or since warm-up
};

/// Steps of walks: column `step * walks + walk` is where the walk was after the step.
struct PopulationDraws {
    Matrix y;
    Vector logDensities;
    Eigen::Index numWalks = 0;
    /// One coordinate: rows are steps, columns are walks.
    Matrix Coordinate(Eigen::Index i) const;
};

/// The worst R-hat of all coordinates.
double MaxRhat(const PopulationDraws& draws);

/// Metropolis' random walks whose proposals have the covariance of the population itself, from windows of a
/// warm-up, and a scale for an acceptance of 0.25; then both are frozen. Between windows the walks do not
/// know of each other: they run in parallel, and a walk's step depends on (seed, walk, step) alone.
class PopulationWalk {
  public:
    struct Options {
        uint64_t seed = 1;
        uint64_t windowSteps = 40;  ///< of each walk
        int numWindows = 5;
    };
    explicit PopulationWalk(const Options& options) : options_(options) {}
    /// @param starts  a column for each walk; more columns than rows, over-dispersed
    PopulationState Start(const Target& target, const Matrix& starts) const;
    /// All windows that are left.
    void Warmup(const Target& target, PopulationState* state) const;
    /// More steps of each walk, after warm-up.
    PopulationDraws Sample(const Target& target, uint64_t numSteps, PopulationState* state) const;

  private:
    PopulationDraws Walk(const Target& target, uint64_t numSteps, PopulationState* state) const;
    Options options_;
};

/// `count` of the columns, evenly spaced.
Matrix ThinnedColumns(const Matrix& columns, Eigen::Index count);
/// Covariance of the columns of a matrix.
Matrix CovarianceOfColumns(const Matrix& columns);
/// L of L L^T = `covariance` plus 1e-9 of its mean variance, so that it always exists.
Matrix CholeskyFactor(const Matrix& covariance);

}  // namespace lacquer::estimate
