// What each family of summaries alone would tell.
#pragma once

#include <vector>

#include "estimate/simulator.h"

namespace lacquer::estimate {

/// For each family, and at last for all of them together, the posterior deviation over the prior one that
/// they would leave of each parameter: by the derivatives of the means and the scatter at one point, as if
/// both were the same everywhere. In logits.
/// @param y     where: the posterior's mean, say
/// @param runs  simulations for the scatter; derivatives take 32 for each parameter, with common seeds
/// @return      a row for each family, the last one for all
Matrix PredictedDeviations(const Simulator& simulator, const std::vector<FamilyRange>& families,
                           const Vector& y, Eigen::Index runs, uint64_t seed);

}  // namespace lacquer::estimate
