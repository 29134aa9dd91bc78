// Pdf "belcour": the density of the lobes of [Belcour 2018], from which LayeredBxDF::Sample() then draws. So
// it is exact, and the weight of a draw is an estimate of the value over it.
#include "layered/estimator.h"
#include "layered/lobes/lobe_sampler.h"

namespace lacquer::layered {
namespace {

class BelcourPdf final : public LayeredPdf {
  public:
    float Evaluate(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                   int /*maxVertices*/) const override {
        return std::max(LobeSampler(stack, wo, context, false).Pdf(wi), 1e-6f);
    }
    bool PrefersLobes(const Stack&) const override { return true; }
};

}  // namespace

LACQUER_REGISTER(LayeredPdfKind, "belcour", MakePdf<BelcourPdf>);

}  // namespace lacquer::layered
