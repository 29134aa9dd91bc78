// Texture "mix": (1 - amount) tex1 + amount tex2.
//
//   "float texture tex1", "spectrum texture tex1"  0
//   "float texture tex2", "spectrum texture tex2"  1
//   "float texture amount"                         0.5
#include "pbrt/base/texture.h"

namespace lacquer {

namespace {

class FloatMix final : public FloatTexture {
  public:
    FloatMix(const FloatTexture* texture1, const FloatTexture* texture2, const FloatTexture* amount)
        : texture1_(texture1), texture2_(texture2), amount_(amount) {}
    float Evaluate(const TextureContext& context) const override {
        const float a = amount_->Evaluate(context);
        const float v1 = a == 1 ? 0 : texture1_->Evaluate(context),
                    v2 = a == 0 ? 0 : texture2_->Evaluate(context);
        return (1 - a) * v1 + a * v2;
    }

  private:
    const FloatTexture *texture1_, *texture2_, *amount_;
};

class SpectrumMix final : public SpectrumTexture {
  public:
    SpectrumMix(const SpectrumTexture* texture1, const SpectrumTexture* texture2, const FloatTexture* amount)
        : texture1_(texture1), texture2_(texture2), amount_(amount) {}
    SampledSpectrum Evaluate(const TextureContext& context, const SampledWavelengths& lambda) const override {
        const float a = amount_->Evaluate(context);
        if (a == 0) return texture1_->Evaluate(context, lambda);
        if (a == 1) return texture2_->Evaluate(context, lambda);
        return (1 - a) * texture1_->Evaluate(context, lambda) + a * texture2_->Evaluate(context, lambda);
    }

  private:
    const SpectrumTexture *texture1_, *texture2_;
    const FloatTexture* amount_;
};

std::unique_ptr<FloatTexture> CreateFloat(const TextureArgs& args) {
    return std::make_unique<FloatMix>(FloatTextureParam(args.params, "tex1", 0, args.textures),
                                      FloatTextureParam(args.params, "tex2", 1, args.textures),
                                      FloatTextureParam(args.params, "amount", 0.5f, args.textures));
}

std::unique_ptr<SpectrumTexture> CreateSpectrum(const TextureArgs& args) {
    return std::make_unique<SpectrumMix>(
        SpectrumTextureParam(args.params, "tex1", args.kind, 0, args.textures),
        SpectrumTextureParam(args.params, "tex2", args.kind, 1, args.textures),
        FloatTextureParam(args.params, "amount", 0.5f, args.textures));
}

}  // namespace

LACQUER_REGISTER(FloatTextureKind, "mix", CreateFloat);
LACQUER_REGISTER(SpectrumTextureKind, "mix", CreateSpectrum);

}  // namespace lacquer
