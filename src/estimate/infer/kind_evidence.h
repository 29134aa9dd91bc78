// Which kind of surface was photographed, if each kind has a posterior of its own.
#pragma once

#include <vector>

#include "estimate/simulator.h"
#include "pbrt/core/progress.h"

namespace lacquer::estimate {

/// A kind: a simulator, all of the same parameters and summaries, and draws of its posterior.
struct KindPosterior {
    const Simulator* simulator;  ///< outlives the object
    Matrix draws;                ///< logits, a column for each; as many as `runs` below, and 80 or more
};

/// Posterior probabilities of kinds that are equally probable beforehand, by the evidence of each: the
/// integral of p(t | y, kind) p(y) over its parameters. The statistics t are not all summaries but what these
/// say of each parameter and of the kind: linear regressions of both on the summaries of `runs` new
/// simulations of every kind, where its posterior lies [Fearnhead and Prangle 2012; Pudlo et al. 2016]. In so
/// few numbers the likelihood of a kind, normal about polynomials of the parameters, is known well; in all
/// summaries it would be an extrapolation from a point that fits none of them exactly. In parallel; the same
/// for any number of threads.
/// @param observed  finite numbers
/// @param runs      of each kind. Probabilities scatter with their seed: for ten parameters and 120 summaries
/// by some 0.2 with 300 of them, by less than 0.1 with 1000 and more
/// @param observer  told of each simulation. Errors: Interrupted, if it asks to stop
std::vector<double> KindProbabilities(const std::vector<KindPosterior>& kinds, const Vector& observed,
                                      Eigen::Index runs, uint64_t seed, Observer* observer = nullptr);

}  // namespace lacquer::estimate
