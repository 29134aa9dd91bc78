// Estimator "pairproduct": short paths by pair products [Xia et al. 2020, sec. 4.3], all others by the walks
// and connections of "bidirectional". Where an interface has no Gaussian lobes it is "bidirectional".
//   pairevents      integer     0    events of the longest path by pair products; 0: those of one pass
//                                    through the stack, or down to its base and back, 7 at most
//   pairstrategies  string      -    how a path may be made: "middle" has the two or three strategies whose
//                                    walks are about equally long, "all" those of the paper. Default
//                                    "middle", but "all" with pairevents: middle strategies of long paths
//                                    have no bound on rare bright estimates
#include "layered/estimators/short_paths.h"
#include "pbrt/core/params.h"

namespace lacquer::layered {
namespace {

/// @tparam Policy  the strategies
template <class Policy>
class PairProductEstimator final : public LayeredEstimator {
  public:
    explicit PairProductEstimator(int maxEvents) : maxEvents_(maxEvents) {}

    SampledSpectrum Evaluate(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                             int maxVertices) const override {
        SampledSpectrum value(0);
        const int wanted = maxEvents_ > 0 ? maxEvents_ : PairVerticesFor(stack, wo, wi);
        const int known = AddPairs<Policy>(stack, wo, wi, context, 2, std::min(maxVertices, wanted), &value);
        CountProductQuery(context, known >= 2);
        return value + EvaluateOthers(stack, wo, wi, context, maxVertices, {known});
    }

  private:
    int maxEvents_;  ///< 0: PairVerticesFor()
};

std::unique_ptr<const LayeredEstimator> CreatePairProduct(const Params& params) {
    const int maxEvents = params.GetIntInRange("pairevents", 0, 0, std::numeric_limits<int>::max());
    const char* const usual = maxEvents > 0 ? "all" : "middle";
    if (params.GetChoice("pairstrategies", usual, {"middle", "all"}) == "all")
        return std::make_unique<PairProductEstimator<AllPairStrategies>>(maxEvents);
    return std::make_unique<PairProductEstimator<PairPolicy>>(maxEvents);
}

}  // namespace

LACQUER_REGISTER(LayeredEstimatorKind, "pairproduct", CreatePairProduct);

}  // namespace lacquer::layered
