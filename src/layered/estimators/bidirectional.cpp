// Estimator "bidirectional": walks from both sides, and connections of all pairs of their vertices by the
// directions that either side draws [Guo et al. 2018, sec. 5.2.2; Guo 2021, app. A.2].
#include "layered/estimators/walk_estimator.h"

namespace lacquer {

LACQUER_REGISTER(LayeredEstimatorKind, "bidirectional", GetWalkEstimator<WalkPolicy>);
// The default: no other estimator has less noise in the same time on all stacks.
LACQUER_REGISTER(LayeredEstimatorKind, "auto", GetWalkEstimator<WalkPolicy>);

}  // namespace lacquer
