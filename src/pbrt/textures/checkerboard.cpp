// Texture "checkerboard": tex1 in the cells whose integer coordinates add up to an even number, tex2 in the
// others; filtered exactly with a tent over the footprint, along each axis separately.
//
//   "float texture tex1", "spectrum texture tex1"  1
//   "float texture tex2", "spectrum texture tex2"  0
//   "integer dimension"                            2  3: cells of texture space instead of a 2D mapping
//   "mapping", "uscale", "vscale", "udelta", "vdelta", "v1", "v2": see texture_mapping.h
#include "pbrt/textures/texture_mapping.h"

namespace lacquer {

namespace {

/// Antiderivative of the antiderivative of the wave, with period 2: second differences of it filter the wave.
float SecondIntegral(float x) {
    const float y = x / 2 - std::floor(x / 2) - 0.5f;
    return y * (1 - 2 * std::abs(y));
}

/// Mean of the wave that is 1 on [2k, 2k+1) and -1 on [2k+1, 2k+2) under a tent of half width r around x.
float FilteredWave(float x, float r) {
    if (!std::isfinite(x)) return 0;
    if (std::floor(x - r) == std::floor(x + r)) return x / 2 - std::floor(x / 2) < 0.5f ? 1.f : -1.f;
    // A tent over thousands of periods sees their mean.
    if (!(r < 1e4f)) return 0;
    return (SecondIntegral(x + r) - 2 * SecondIntegral(x) + SecondIntegral(x - r)) / (r * r);
}

/// Half width of the tent for the changes of a coordinate to the neighbouring pixels; 1.5 is pbrt's.
float TentRadius(float dx, float dy) { return 1.5f * std::max(std::abs(dx), std::abs(dy)); }

/// The share of tex2 at a point.
class CheckerWeight {
  public:
    explicit CheckerWeight(const TextureArgs& args) {
        const int dimension = args.params.GetInt("dimension", 2);
        if (dimension != 2 && dimension != 3)
            args.params.Fail("dimension", "\"integer dimension\" of a checkerboard must be 2 or 3");
        if (dimension == 2)
            mapping2D_ = MakeTextureMapping2D(args);
        else
            mapping3D_.emplace(args);
    }
    float Share2(const TextureContext& context) const {
        float wave = 1;
        if (mapping2D_) {
            const TextureFootprint f = mapping2D_->Map(context);
            for (int i = 0; i < 2; ++i) wave *= FilteredWave(f.st[i], TentRadius(f.dstdx[i], f.dstdy[i]));
        } else {
            const TexturePoint c = mapping3D_->Map(context);
            for (int i = 0; i < 3; ++i) wave *= FilteredWave(c.p[i], TentRadius(c.dpdx[i], c.dpdy[i]));
        }
        return 0.5f - 0.5f * wave;
    }

  private:
    std::unique_ptr<TextureMapping2D> mapping2D_;
    std::optional<TextureMapping3D> mapping3D_;  ///< set if mapping2D_ is not
};

class FloatCheckerboard final : public FloatTexture {
  public:
    explicit FloatCheckerboard(const TextureArgs& args)
        : weight_(args),
          texture1_(FloatTextureParam(args.params, "tex1", 1, args.textures)),
          texture2_(FloatTextureParam(args.params, "tex2", 0, args.textures)) {}
    float Evaluate(const TextureContext& context) const override {
        const float share = weight_.Share2(context);
        const float v1 = share == 1 ? 0 : texture1_->Evaluate(context);
        const float v2 = share == 0 ? 0 : texture2_->Evaluate(context);
        return (1 - share) * v1 + share * v2;
    }

  private:
    CheckerWeight weight_;
    const FloatTexture *texture1_, *texture2_;
};

class SpectrumCheckerboard final : public SpectrumTexture {
  public:
    explicit SpectrumCheckerboard(const TextureArgs& args)
        : weight_(args),
          texture1_(SpectrumTextureParam(args.params, "tex1", args.kind, 1, args.textures)),
          texture2_(SpectrumTextureParam(args.params, "tex2", args.kind, 0, args.textures)) {}
    SampledSpectrum Evaluate(const TextureContext& context, const SampledWavelengths& lambda) const override {
        const float share = weight_.Share2(context);
        if (share == 0) return texture1_->Evaluate(context, lambda);
        if (share == 1) return texture2_->Evaluate(context, lambda);
        return (1 - share) * texture1_->Evaluate(context, lambda) +
               share * texture2_->Evaluate(context, lambda);
    }

  private:
    CheckerWeight weight_;
    const SpectrumTexture *texture1_, *texture2_;
};

std::unique_ptr<FloatTexture> CreateFloat(const TextureArgs& args) {
    return std::make_unique<FloatCheckerboard>(args);
}

std::unique_ptr<SpectrumTexture> CreateSpectrum(const TextureArgs& args) {
    return std::make_unique<SpectrumCheckerboard>(args);
}

}  // namespace

LACQUER_REGISTER(FloatTextureKind, "checkerboard", CreateFloat);
LACQUER_REGISTER(SpectrumTextureKind, "checkerboard", CreateSpectrum);

}  // namespace lacquer
