// Estimator "bidirectional": walks from both sides, and connections of all pairs of their vertices by the
// directions that either side draws [Guo et al. 2018, sec. 5.2.2; Guo 2021, app. A.2].
#include "layered/estimators/walk_estimator.h"

namespace lacquer::layered {

LACQUER_REGISTER(LayeredEstimatorKind, "bidirectional", MakeEstimator<WalkEstimator<WalkPolicy>>);

}  // namespace lacquer::layered
