// Which direction to measure next.
#pragma once

#include <vector>

#include "estimate/layered/lobe_data.h"
#include "estimate/layered/measurement.h"

namespace lacquer::estimate {

/// What a measurement in some direction would tell.
struct NextDirection {
    DirectionAngles direction;
    double deviation;  ///< of its predicted logarithm over the posterior, root mean square over channels
    double ratio;      ///< of that variance to the noise of a measurement: it tells nothing new at 0
};

/// All directions, the one that tells most first. Predictions differ between draws of the posterior by what
/// is not known of the parameters, and by noise of simulations, which is no uncertainty of them: only what
/// follows the parameters counts (their part in a linear regression).
/// @param draws      of the parameters, logits, a column for each; at least twice as many as rows
/// @param predicted  at these: logarithms, a row for each draw, the channels of a direction side by side
/// @param noise      relative, of a measurement
std::vector<NextDirection> RankDirections(const std::vector<DirectionAngles>& directions, const Matrix& draws,
                                          const Matrix& predicted, double noise);

}  // namespace lacquer::estimate
