// Estimator "bidirectional": walks from both sides, and connections of all pairs of their vertices by the
// directions that either side draws [Guo et al. 2018, sec. 5.2.2; Guo 2021, app. A.2].
#include "layered/connection_walk.h"
#include "layered/estimator.h"

namespace lacquer {
namespace {

class BidirectionalEstimator final : public LayeredEstimator {
  public:
    SampledSpectrum Evaluate(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                             int maxVertices) const override {
        return ConnectionWalk<WalkPolicy>(stack, context, maxVertices).Estimate(wo, wi);
    }
};

const LayeredEstimator* GetBidirectional() {
    static const BidirectionalEstimator estimator;
    return &estimator;
}

}  // namespace

LACQUER_REGISTER(LayeredEstimatorKind, "bidirectional", GetBidirectional);
// The default: no other estimator has less noise in the same time on all stacks.
LACQUER_REGISTER(LayeredEstimatorKind, "auto", GetBidirectional);

}  // namespace lacquer
