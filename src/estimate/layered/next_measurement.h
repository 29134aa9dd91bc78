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

/// All directions, the one that tells most first.
/// @param predicted  at draws of the posterior: logarithms, a row for each draw, the channels of a direction
///                   side by side; their errors' variance is no uncertainty of the parameters and is left out
/// @param noise      relative, of a measurement
std::vector<NextDirection> RankDirections(const std::vector<DirectionAngles>& directions,
                                          const LobeRuns& predicted, double noise);

}  // namespace lacquer::estimate
