// Pdf "approximate": the density of the short paths that only interfaces make, and a constant for all others
// [Guo et al. 2018, sec. 5.3.2]. The paper takes the media away; here these paths count by the chance that no
// slab scatters them, which is what the images published with it show, and what Sample() does.
#include "layered/pdfs/density_walk.h"

namespace lacquer::layered {
namespace {

/// Stands for scattering and long paths [1/sr], as the paper has it.
constexpr float kConstant = 0.1f;

class ApproximatePdf final : public LayeredPdf {
  public:
    float Evaluate(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                   int maxVertices) const override {
        const int numSlabs = stack.Last();
        const int longest = SameHemisphere(wo, wi) ? 2 * numSlabs + 1 : numSlabs + 1;
        return DensityOfExit<UnscatteredDensityPolicy>(stack, wo, wi, context,
                                                       std::min(maxVertices, longest)) +
               kConstant;
    }
};

}  // namespace

LACQUER_REGISTER(LayeredPdfKind, "approximate", MakePdf<ApproximatePdf>);

}  // namespace lacquer::layered
