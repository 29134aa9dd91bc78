// Estimator "forward": one walk from the camera side; at every visit to the interface where light enters, its
// value for the light's direction is added [Xia et al. 2020, sec. 4.1]. Through specular interfaces light is
// followed in, since no evaluation can find it behind them.
#include "layered/estimators/walk_estimator.h"

namespace lacquer::layered {
namespace {

struct ForwardPolicy : WalkPolicy {
    static constexpr Strategies kStrategies = Strategies::Forward;
};

}  // namespace

LACQUER_REGISTER(LayeredEstimatorKind, "forward", MakeEstimator<WalkEstimator<ForwardPolicy>>);

}  // namespace lacquer::layered
