// Estimator "halfvector": the lead chain through the facets that it meets, all other light by walks from both
// sides.
#include "layered/chains/half_vectors/lead.h"
#include "layered/connection_walk.h"
#include "layered/estimator.h"

namespace lacquer::layered {
namespace {

class HalfVectorEstimator final : public LayeredEstimator {
  public:
    SampledSpectrum Evaluate(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                             int maxVertices) const override {
        Chain chain;
        SampledSpectrum lead(0);
        KnownPaths known;
        if (FindChain(stack, wo, wi, maxVertices, &chain)) {
            if (const LeadMethod method = LeadMethodFor(chain); method != LeadMethod::None) {
                lead = EstimateLead(method, chain, context);
                known.vertices = chain.numEvents;
            }
        }
        CountProductQuery(context, known.vertices > 0);
        return lead + ConnectionWalk<WalkPolicy>(stack, context, maxVertices, known).Estimate(wo, wi);
    }
};

}  // namespace

LACQUER_REGISTER(LayeredEstimatorKind, "halfvector", MakeEstimator<HalfVectorEstimator>);

}  // namespace lacquer::layered
