// Estimator "forward": one walk from the camera side; at every visit to the interface where light enters, its
// value for the light's direction is added [Xia et al. 2020, sec. 4.1]. Through specular interfaces light is
// followed in, since no evaluation can find it behind them.
#include "layered/connection_walk.h"
#include "layered/estimator.h"

namespace lacquer {
namespace {

struct ForwardPolicy : WalkPolicy {
    static constexpr Strategies kStrategies = Strategies::Forward;
};

class ForwardEstimator final : public LayeredEstimator {
  public:
    SampledSpectrum Evaluate(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                             int maxVertices) const override {
        return ConnectionWalk<ForwardPolicy>(stack, context, maxVertices).Estimate(wo, wi);
    }
};

const LayeredEstimator* GetForward() {
    static const ForwardEstimator estimator;
    return &estimator;
}

}  // namespace

LACQUER_REGISTER(LayeredEstimatorKind, "forward", GetForward);

}  // namespace lacquer
