// Estimator "auto": per query, the method with the least noise for its time.
//
// The closed form over a Lambertian base; else what PlanQuery() says: the shortest path by product sampling
// or pair products, where that carries much of the noise, long paths by their own walk, and connections of
// walks from both sides for all other light.
#include "layered/estimators/query_plan.h"
#include "layered/lambertian/lambertian_base.h"

namespace lacquer::layered {
namespace {

/// Apart, so that estimates by connections pay for nothing but the questions.
[[gnu::noinline]] SampledSpectrum EstimatePlanned(const Stack& stack, Vec3 wo, Vec3 wi,
                                                  const BxDFContext& context, int maxVertices) {
    LambertianBase base;
    if (std::holds_alternative<LambertianSurface>(stack.interfaces.back().model) &&
        FindLambertianBase(stack, wo, wi, &base))
        return EvaluateLambertianBase(base, wo, wi, maxVertices);
    const QueryPlan plan = PlanQuery(stack, wo, wi, maxVertices);
    const bool isPlain = plan.shortest == PathMethod::Connection;
    CountProductQuery(context, !isPlain);
    if (isPlain) return EstimateByConnections(stack, wo, wi, context, maxVertices);
    return EstimateByPlan(plan, stack, wo, wi, context, maxVertices);
}

class AutoEstimator final : public LayeredEstimator {
  public:
    SampledSpectrum Evaluate(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                             int maxVertices) const override {
        if (stack.Last() == 0) return SampledSpectrum(0);
        if (HasPlans(stack, wo, wi) ||
            std::holds_alternative<LambertianSurface>(stack.interfaces.back().model))
            return EstimatePlanned(stack, wo, wi, context, maxVertices);
        CountProductQuery(context, false);
        return EstimateByConnections(stack, wo, wi, context, maxVertices);
    }

    bool UsesClosedForms() const override { return true; }
};

}  // namespace

LACQUER_REGISTER(LayeredEstimatorKind, "auto", MakeEstimator<AutoEstimator>);

}  // namespace lacquer::layered
