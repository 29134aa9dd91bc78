// The estimators that are a set of strategies of ConnectionWalk.
#pragma once

#include "layered/connection_walk.h"
#include "layered/estimator.h"

namespace lacquer::layered {

template <class Policy>
class WalkEstimator final : public LayeredEstimator {
  public:
    SampledSpectrum Evaluate(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                             int maxVertices) const override {
        return ConnectionWalk<Policy>(stack, context, maxVertices).Estimate(wo, wi);
    }
};

}  // namespace lacquer::layered
