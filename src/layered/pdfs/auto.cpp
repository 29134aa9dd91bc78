// Pdf "auto": per stack, lobes where they fit and most of the light that enters is absorbed, else "gaussian".
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

bool ScattersBack(const PhaseFunction& phase) {
    const Vec3 w{0, 0, 1};
    return phase.Evaluate(w, w).p > 1.01f * phase.Evaluate(w, -w).p;
}

/// True if lobes know where the stack's light goes. What they miss is found by their floor alone, in draws of
/// large weights: perturbed normals below, sharp lobes that one mean alpha hides, unknown interfaces, slabs
/// that scatter back.
bool LobesFit(const Stack& stack) {
    constexpr size_t kMaxInterfaces = 4;
    constexpr float kMaxQuotient = 4;
    if (stack.interfaces.size() > kMaxInterfaces) return false;
    float least = 1, most = 0;
    for (const StackInterface& interface : stack.interfaces) {
        if (!interface.HasUnperturbedNormal()) return false;
        if (std::holds_alternative<std::monostate>(interface.model)) return false;
        if (const auto* facets = std::get_if<MicrofacetSurface>(&interface.model)) {
            least = std::min({least, facets->alphaX, facets->alphaY});
            most = std::max({most, facets->alphaX, facets->alphaY});
        }
    }
    for (const Slab& slab : stack.slabs)
        if (slab.Scatters() && (slab.phase->HasDirectionalExtinction() || ScattersBack(*slab.phase)))
            return false;
    return most <= kMaxQuotient * least;
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
        return !stack.interfaces.back().transmits && LobesFit(stack) && ReturningShare(stack) < kDark;
    }

  private:
    std::unique_ptr<const LayeredPdf> gaussian_;
};

std::unique_ptr<const LayeredPdf> Create(const Params& params) { return std::make_unique<AutoPdf>(params); }

}  // namespace

LACQUER_REGISTER(LayeredPdfKind, "auto", Create);

}  // namespace lacquer::layered
