// Whether chains agree with each other, and how much their draws are worth.
#pragma once

#include <vector>

#include "estimate/linear_algebra.h"

namespace lacquer::estimate {

// All take draws of one scalar: rows are draws in their order, columns are chains. They need at least four
// draws a chain, and are NaN for fewer, for draws that are not finite, and for draws that are all the same.

/// Rank-normalised split R-hat, the larger of that of the draws and that of their distances from the median:
/// 1 where chains agree; above 1.01 they have not converged [Vehtari et al. 2021].
double SplitRhat(const Matrix& draws);
/// Number of independent draws that give the mean of rank-normalised draws as well [Vehtari et al. 2021];
/// above 400 it is enough.
double BulkEss(const Matrix& draws);
/// The same for the quantiles at 5 % and 95 %: the smaller of the two.
double TailEss(const Matrix& draws);
/// The same for the mean of the draws themselves, by Geyer's initial monotone sequence [Geyer 1992]. Halves
/// of chains count as chains. At most n log10(n) for n draws.
double MeanEss(const Matrix& draws);

/// Energy's Bayesian fraction of missing information of one chain: mean squared difference of neighbouring
/// energies over their variance; below 0.3 momenta explore the energies too slowly [Betancourt 2016]. NaN for
/// fewer than two draws.
double EBfmi(const std::vector<double>& energies);

/// What a report has for one parameter.
struct Convergence {
    double rhat, bulkEss, tailEss;
};
Convergence ConvergenceOf(const Matrix& draws);

}  // namespace lacquer::estimate
