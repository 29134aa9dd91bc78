// Estimator "belcour": not the light of the stack but an approximation of it, by the lobes of [Belcour 2018].
// No noise, and an error that no time takes away; see docs/layered.md. Sample() draws from the same lobes.
#include "layered/estimator.h"
#include "layered/lobes/belcour_lobes.h"

namespace lacquer::layered {
namespace {

class BelcourEstimator final : public LayeredEstimator {
  public:
    SampledSpectrum Evaluate(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                             int maxVertices) const override {
        if (stack.Last() == 0 || maxVertices < 2) return SampledSpectrum(0);
        return BelcourLobes(stack, wo, context.rng).Evaluate(wi, context.mode);
    }
    bool IsLobes() const override { return true; }
};

}  // namespace

LACQUER_REGISTER(LayeredEstimatorKind, "belcour", MakeEstimator<BelcourEstimator>, {.isApproximate = true});

}  // namespace lacquer::layered
