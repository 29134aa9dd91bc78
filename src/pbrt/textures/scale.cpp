// Texture "scale": the product of tex and scale.
//
//   "float texture tex", "spectrum texture tex"  1
//   "float texture scale"                        1
#include "pbrt/textures/imagemap.h"

namespace lacquer {

namespace {

class FloatScale final : public FloatTexture {
  public:
    FloatScale(const FloatTexture* texture, const FloatTexture* scale) : texture_(texture), scale_(scale) {}
    float Evaluate(const TextureContext& context) const override {
        const float scale = scale_->Evaluate(context);
        return scale == 0 ? 0 : texture_->Evaluate(context) * scale;
    }

  private:
    const FloatTexture *texture_, *scale_;
};

class SpectrumScale final : public SpectrumTexture {
  public:
    SpectrumScale(const SpectrumTexture* texture, const FloatTexture* scale)
        : texture_(texture), scale_(scale) {}
    SampledSpectrum Evaluate(const TextureContext& context, const SampledWavelengths& lambda) const override {
        const float scale = scale_->Evaluate(context);
        return scale == 0 ? SampledSpectrum(0) : texture_->Evaluate(context, lambda) * scale;
    }

  private:
    const SpectrumTexture* texture_;
    const FloatTexture* scale_;
};

// A constant factor of an image texture goes into the image's own scale, as in pbrt. It matters where the
// image is inverted: the result is 1 - scale * image, not scale * (1 - image).
std::unique_ptr<FloatTexture> CreateFloat(const TextureArgs& args) {
    const FloatTexture* texture = FloatTextureParam(args.params, "tex", 1, args.textures);
    const FloatTexture* scale = FloatTextureParam(args.params, "scale", 1, args.textures);
    for (const auto& [image, factor] :
         {std::pair(texture, scale->Constant()), std::pair(scale, texture->Constant())}) {
        if (!factor) continue;
        if (auto folded = ScaledImageMap(*image, *factor)) return folded;
    }
    return std::make_unique<FloatScale>(texture, scale);
}

std::unique_ptr<SpectrumTexture> CreateSpectrum(const TextureArgs& args) {
    const SpectrumTexture* texture = SpectrumTextureParam(args.params, "tex", args.kind, 1, args.textures);
    const FloatTexture* scale = FloatTextureParam(args.params, "scale", 1, args.textures);
    if (const std::optional<float> factor = scale->Constant())
        if (auto folded = ScaledImageMap(*texture, *factor)) return folded;
    return std::make_unique<SpectrumScale>(texture, scale);
}

}  // namespace

LACQUER_REGISTER(FloatTextureKind, "scale", CreateFloat);
LACQUER_REGISTER(SpectrumTextureKind, "scale", CreateSpectrum);

}  // namespace lacquer
