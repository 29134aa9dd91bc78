// Which kind of surface was photographed, if each kind has a posterior of its own.
#pragma once

#include <vector>

#include "estimate/simulator.h"

namespace lacquer::estimate {

/// A kind: a simulator, all of the same parameters and summaries, and draws of its posterior.
struct KindPosterior {
    const Simulator* simulator;  ///< outlives the object
    Matrix draws;                ///< logits, a column for each; more of them than rows
};

/// Posterior probabilities of kinds that are equally probable beforehand. The evidence of each is
///
///     p(S | y) p(y) / p(y | S)
///
/// at the mean y of its draws, in all summaries: their likelihood there is that of `runs` new simulations for
/// each kind, whose scatter is pooled, so that all are compared in the same units; the posterior's density is
/// that of a normal distribution with the draws' covariance [Chib 1995]. In parallel; the same for any number
/// of threads.
std::vector<double> KindProbabilities(const std::vector<KindPosterior>& kinds, const Vector& observed,
                                      Eigen::Index runs, uint64_t seed);

}  // namespace lacquer::estimate
