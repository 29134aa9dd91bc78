// Estimator "bidirectional": walks from both sides, and connections of all pairs of their vertices by the
// directions that either side draws [Guo et al. 2018, sec. 5.2.2; Guo 2021, app. A.2].
#include "layered/connection_walk.h"
#include "layered/estimators/query_plan.h"

namespace lacquer::layered {

// One function for all who take connections alone: where compilers make two of the same walk, the times of
// both differ by up to a tenth. Nothing else is in its stack frame for the same reason: a walk is 20 kB, and
// where other variables shift it, its time grows.
[[gnu::noinline]] SampledSpectrum EstimateByConnections(const Stack& stack, Vec3 wo, Vec3 wi,
                                                        const BxDFContext& context, int maxVertices) {
    return ConnectionWalk<WalkPolicy>(stack, context, maxVertices).Estimate(wo, wi);
}

namespace {

class BidirectionalEstimator final : public LayeredEstimator {
  public:
    SampledSpectrum Evaluate(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                             int maxVertices) const override {
        return EstimateByConnections(stack, wo, wi, context, maxVertices);
    }
};

}  // namespace

LACQUER_REGISTER(LayeredEstimatorKind, "bidirectional", MakeEstimator<BidirectionalEstimator>);

}  // namespace lacquer::layered
