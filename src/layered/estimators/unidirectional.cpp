// Estimator "unidirectional": a walk from the camera side with next-event estimation [Guo et al. 2018, sec.
// 5.2.1]. At every vertex the light is met by a direction drawn backwards through the interface where it
// enters, weighted against continuing the walk.
//
// Across several slabs the paper nests: the lower slabs become the BSDF of the upper one's lower interface.
// Here light goes straight in through as many interfaces as it can, and all cuts of the path inside that run
// are weighted against each other. Every path is counted once, the cost is linear in its length, and no
// stochastic BSDF enters a weight.
#include "layered/estimators/walk_estimator.h"

namespace lacquer::layered {
namespace {

struct UnidirectionalPolicy : WalkPolicy {
    static constexpr Strategies kStrategies = Strategies::NextEvent;
};

}  // namespace

LACQUER_REGISTER(LayeredEstimatorKind, "unidirectional", MakeEstimator<WalkEstimator<UnidirectionalPolicy>>);

}  // namespace lacquer::layered
