// Estimator "auto": per query, the method with the least noise for its time.
//
// In this order: the closed form over a Lambertian base; under a rough coat over a rough base, a plan of
// product sampling and long paths; the shortest path by product sampling where it matters; and walks from
// both sides for all other light. The rules follow measurements, see docs/product-sampling.md.
#include "layered/estimators/short_paths.h"
#include "layered/lambertian/lambertian_base.h"
#include "layered/paths/half_vectors/shortest_path.h"
#include "layered/paths/long_paths/long_path_plan.h"

namespace lacquer::layered {
namespace {

class AutoEstimator final : public LayeredEstimator {
  public:
    SampledSpectrum Evaluate(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                             int maxVertices) const override {
        if (stack.Last() == 0) return SampledSpectrum(0);
        LambertianBase base;
        if (FindLambertianBase(stack, wo, wi, &base))
            return EvaluateLambertianBase(base, wo, wi, maxVertices);

        InterfacePath path;
        const ShortestPathMethod shortest =
            ShortestPathMatters(stack, wo, wi) && FindShortestPath(stack, wo, wi, maxVertices, &path)
                ? ShortestPathMethodFor(path)
                : ShortestPathMethod::None;
        CountProductQuery(context, shortest != ShortestPathMethod::None);
        if (LongPathWalkApplies(stack, wo, wi)) {
            const LongPathPlan plan =
                PlanLongPaths(*stack.interfaces[0].IsotropicFacets(), *stack.interfaces[1].IsotropicFacets(),
                              shortest != ShortestPathMethod::None);
            return EstimateByPlan(plan, stack, wo, wi, context, maxVertices,
                                  [&] { return EstimateShortestPath(shortest, path, context); });
        }
        if (shortest == ShortestPathMethod::None)
            return ConnectionWalk<WalkPolicy>(stack, context, maxVertices).Estimate(wo, wi);
        return EstimateShortestPath(shortest, path, context) +
               EvaluateOthers(stack, wo, wi, context, maxVertices, {path.numEvents});
    }

    bool UsesClosedForms() const override { return true; }

  private:
    /// True where the shortest path carries much of the noise: off metal below one coat, and straight
    /// through. Elsewhere (what slabs scatter, what dielectrics reflect between each other) a better estimate
    /// of this one path is not worth its time.
    static bool ShortestPathMatters(const Stack& stack, Vec3 wo, Vec3 wi) {
        if (stack.Scatters()) return false;
        if (!SameHemisphere(wo, wi)) return true;
        return stack.Last() == 1 && wo.z > 0 && !stack.interfaces[1].transmits;
    }
};

}  // namespace

LACQUER_REGISTER(LayeredEstimatorKind, "auto", MakeEstimator<AutoEstimator>);

}  // namespace lacquer::layered
