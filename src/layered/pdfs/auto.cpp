// Pdf "auto": per stack, lobes where most of the light that enters is absorbed, else "gaussian".
//
// Walks go by what they meet first: of the light that enters a dark stack most of the draws end there, and
// what the coat reflects, nearly all of the light, gets few. Lobes are drawn by energy, which makes up for
// it, but a draw takes half as long again, and its weight has the noise of a value.
#include "layered/estimator.h"
#include "layered/lobes/layer_operators.h"

namespace lacquer::layered {
namespace {

/// About the part of the light below the first interface that comes back, mean over the wavelengths: of metal
/// most, of a slab what a half-space reflects and what gets through it twice.
float ReturningShare(const Stack& stack) {
    constexpr float kMetal = 0.8f, kMeanPath = 2.4f;  // down and up at middle angles
    SampledSpectrum back(kMetal);
    if (const auto* base = std::get_if<LambertianSurface>(&stack.interfaces.back().model))
        back = base->reflectance;
    for (size_t k = stack.slabs.size(); k-- > 0;) {
        const Slab& slab = stack.slabs[k];
        if (slab.IsClear()) continue;
        const SampledSpectrum absorbed = Max(SampledSpectrum(1) - slab.albedo, SampledSpectrum(0));
        if (!slab.Scatters()) {
            back *= Exp(-(slab.opticalThickness * kMeanPath));
            continue;
        }
        const SampledSpectrum turned =
            Max(SampledSpectrum(1) - slab.albedo * MeanCosineOf(*slab.phase), SampledSpectrum(1e-6f));
        const auto root = [](SampledSpectrum x) { return Map(x, [](float v) { return std::sqrt(v); }); };
        const SampledSpectrum s = root(absorbed / turned);
        const SampledSpectrum halfSpace = (SampledSpectrum(1) - s) / (SampledSpectrum(1) + s);
        const SampledSpectrum through = Exp(-(slab.opticalThickness * root(absorbed * turned) * kMeanPath));
        back = halfSpace + (back - halfSpace) * through;
    }
    return back.Average();
}

class AutoPdf final : public LayeredPdf {
  public:
    explicit AutoPdf(const Params& params) : gaussian_(Registry<LayeredPdfKind>::Find("gaussian")(params)) {}

    float Evaluate(const Stack& stack, Vec3 wo, Vec3 wi, const BxDFContext& context,
                   int maxVertices) const override {
        return gaussian_->Evaluate(stack, wo, wi, context, maxVertices);
    }
    bool PrefersLobes(const Stack& stack) const override {
        constexpr float kDark = 0.3f;
        return !stack.interfaces.back().transmits && ReturningShare(stack) < kDark;
    }

  private:
    std::unique_ptr<const LayeredPdf> gaussian_;
};

std::unique_ptr<const LayeredPdf> Create(const Params& params) { return std::make_unique<AutoPdf>(params); }

}  // namespace

LACQUER_REGISTER(LayeredPdfKind, "auto", Create);

}  // namespace lacquer::layered
