// Whether importance weights can be trusted: the shape of their tail.
#pragma once

#include <vector>

namespace lacquer::estimate {

/// Weights with a smoothed tail.
struct SmoothedWeights {
    std::vector<double> weights;  ///< normalised, in the order of the input
    /// Shape of the generalised Pareto distribution of the largest weights: below 0.5 the weights have a
    /// variance, up to 0.7 their means are usable, above they are not. Infinite if the tail has fewer than
    /// five weights that differ.
    double k;
};
/// Pareto-smoothed importance sampling [Vehtari et al. 2024].
/// @param logWeights  logarithms of weights up to a common constant; -inf is a weight of 0
SmoothedWeights ParetoSmooth(const std::vector<double>& logWeights);

/// Generalised Pareto distribution of exceedances, shape k and scale sigma; k > 0 is a heavy tail.
struct GeneralizedPareto {
    double k, sigma;
    double Quantile(double p) const;
};
/// Its fit to positive exceedances in ascending order, at least five [Zhang and Stephens 2009].
GeneralizedPareto FitGeneralizedPareto(const std::vector<double>& exceedances);

}  // namespace lacquer::estimate
