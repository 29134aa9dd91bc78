// Estimator "pairproduct": the shortest paths by pair products [Xia et al. 2020, sec. 4.3], all others by the
// walks and connections of "bidirectional". Where an interface has no Gaussian lobes it is "bidirectional".
#include "layered/estimators/short_paths.h"

namespace lacquer::layered {
namespace {

class PairProductEstimator final : public LayeredEstimator {
  public:
    SampledSpectrum Evaluate(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                             int maxVertices) const override {
        SampledSpectrum value(0);
        const int known = AddPairs(stack, wo, wi, context, 2,
                                   std::min(maxVertices, PairVerticesFor(stack, wo, wi)), &value);
        CountProductQuery(context, known >= 2);
        return value + EvaluateOthers(stack, wo, wi, context, maxVertices, {known});
    }
};

}  // namespace

LACQUER_REGISTER(LayeredEstimatorKind, "pairproduct", MakeEstimator<PairProductEstimator>);

}  // namespace lacquer::layered
