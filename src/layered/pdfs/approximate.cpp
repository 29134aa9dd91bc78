// Pdf "approximate": the density of the short paths that only interfaces make, and a constant for all others
// [Guo et al. 2018, sec. 5.3.2].
#include <array>

#include "layered/pdfs/density_walk.h"

namespace lacquer {
namespace {

/// Stands for scattering and long paths [1/sr], as the paper has it.
constexpr float kConstant = 0.1f;
constexpr size_t kMaxSlabs = 64;

class ApproximatePdf final : public LayeredPdf {
  public:
    float Evaluate(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                   int maxVertices) const override {
        static const std::array<Slab, kMaxSlabs> kClear{};
        Stack clear = stack;
        clear.slabs = std::span(kClear).first(std::min(stack.slabs.size(), kMaxSlabs));
        const int numSlabs = stack.Last();
        const int longest = SameHemisphere(wo, wi) ? 2 * numSlabs + 1 : numSlabs + 1;
        return DensityOfExit(clear, wo, wi, context, std::min(maxVertices, longest)) + kConstant;
    }
};

const LayeredPdf* GetApproximate() {
    static const ApproximatePdf pdf;
    return &pdf;
}

}  // namespace

LACQUER_REGISTER(LayeredPdfKind, "approximate", GetApproximate);

}  // namespace lacquer
