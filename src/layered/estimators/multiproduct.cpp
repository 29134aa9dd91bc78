// Estimator "multiproduct": the first path of three vertices from one Gaussian over both of its inner
// directions [Xia et al. 2020, sec. 4.4], the other paths of one pass by pair products, all others by the
// walks of "bidirectional". Where a multiple product is impossible or known to be worse, it is "pairproduct".
#include "layered/chains/multi_product.h"
#include "layered/estimators/short_paths.h"

namespace lacquer {
namespace {

class MultiProductEstimator final : public LayeredEstimator {
  public:
    SampledSpectrum Evaluate(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                             int maxVertices) const override {
        SampledSpectrum value(0);
        int known = 1;
        Chain chain;
        MultiProduct product;
        // The one path of at most three vertices.
        if (FindChain(stack, wo, wi, std::min(maxVertices, kVertices), &chain) && product.Set(chain)) {
            value = product.Estimate(context.mode, *context.rng);
            known = kVertices;
        }
        known = AddPairs(stack, wo, wi, context, known + 1,
                         std::min(maxVertices, PairVerticesFor(stack, wo, wi)), &value);
        CountProductQuery(context, known >= 2);
        return value + EvaluateOthers(stack, wo, wi, context, maxVertices, known);
    }

  private:
    static constexpr int kVertices = 3;
};

}  // namespace

LACQUER_REGISTER(LayeredEstimatorKind, "multiproduct", TheEstimator<MultiProductEstimator>);

}  // namespace lacquer
