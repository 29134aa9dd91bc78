// Estimator "auto": per query, the method with the least noise for its time.
//
// In this order: the closed form over a Lambertian base; under a rough coat over a rough base, a plan of
// product sampling and long chains; the lead chain by product sampling where it matters; and walks from both
// sides for all other light. The rules follow measurements, see docs/product-sampling.md.
#include "layered/chains/half_vectors/lead.h"
#include "layered/chains/long_chains/long_chain_plan.h"
#include "layered/estimators/short_paths.h"
#include "layered/lambertian/lambertian_base.h"

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

        Chain chain;
        const LeadMethod lead = LeadMatters(stack, wo, wi) && FindChain(stack, wo, wi, maxVertices, &chain)
                                    ? LeadMethodFor(chain)
                                    : LeadMethod::None;
        CountProductQuery(context, lead != LeadMethod::None);
        if (LongChainApplies(stack, wo, wi)) {
            const LongPathPlan plan =
                PlanLongPaths(*stack.interfaces[0].IsotropicFacets(), *stack.interfaces[1].IsotropicFacets(),
                              lead != LeadMethod::None);
            return EstimateByPlan(plan, stack, wo, wi, context, maxVertices,
                                  [&] { return EstimateLead(lead, chain, context); });
        }
        if (lead == LeadMethod::None)
            return ConnectionWalk<WalkPolicy>(stack, context, maxVertices).Estimate(wo, wi);
        return EstimateLead(lead, chain, context) +
               EvaluateOthers(stack, wo, wi, context, maxVertices, {chain.numEvents});
    }

    bool UsesClosedForms() const override { return true; }

  private:
    /// True where the lead chain carries much of the noise: off metal below one coat, and straight through.
    /// Elsewhere (what slabs scatter, what dielectrics reflect between each other) a better estimate of this
    /// one chain does not pay for its time.
    static bool LeadMatters(const Stack& stack, Vec3 wo, Vec3 wi) {
        if (stack.Scatters()) return false;
        if (!SameHemisphere(wo, wi)) return true;
        return stack.Last() == 1 && wo.z > 0 && !stack.interfaces[1].transmits;
    }
};

}  // namespace

LACQUER_REGISTER(LayeredEstimatorKind, "auto", MakeEstimator<AutoEstimator>);

}  // namespace lacquer::layered
