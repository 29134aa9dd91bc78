// Pdf "unbiased": estimates the density of all paths [Guo et al. 2018, sec. 5.3.1]. As expensive as a value.
#include "layered/pdfs/density_walk.h"

namespace lacquer::layered {
namespace {

class UnbiasedPdf final : public LayeredPdf {
  public:
    float Evaluate(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                   int maxVertices) const override {
        return DensityOfExit<DensityPolicy>(stack, wo, wi, context, maxVertices);
    }
};

}  // namespace

LACQUER_REGISTER(LayeredPdfKind, "unbiased", MakePdf<UnbiasedPdf>);

}  // namespace lacquer::layered
