// Texture "dots": in about half of the unit cells of (s, t) a disk of radius 0.35, offset a little from the
// centre of the cell. The names are swapped, as in pbrt.
//
//   "float texture inside", "spectrum texture inside"    1  what is around the disks
//   "float texture outside", "spectrum texture outside"  0  what the disks show
//   "mapping", "uscale", "vscale", "udelta", "vdelta", "v1", "v2": see texture_mapping.h
#include "pbrt/textures/noise.h"
#include "pbrt/textures/texture_mapping.h"

namespace lacquer {

namespace {

bool InDot(Point2 st) {
    const float s = std::floor(st.x + 0.5f), t = std::floor(st.y + 0.5f);
    if (!(Noise(s + 0.5f, t + 0.5f) > 0)) return false;
    constexpr float kRadius = 0.35f, kShift = 0.15f;
    const Point2 center(s + kShift * Noise(s + 1.5f, t + 2.8f), t + kShift * Noise(s + 4.5f, t + 9.8f));
    const Vec2 d = st - center;
    return d.x * d.x + d.y * d.y < kRadius * kRadius;
}

class FloatDots final : public FloatTexture {
  public:
    explicit FloatDots(const TextureArgs& args)
        : mapping_(MakeTextureMapping2D(args)),
          around_(FloatTextureParam(args.params, "inside", 1, args.textures)),
          dot_(FloatTextureParam(args.params, "outside", 0, args.textures)) {}
    float Evaluate(const TextureContext& context) const override {
        return (InDot(mapping_->Map(context).st) ? dot_ : around_)->Evaluate(context);
    }

  private:
    std::unique_ptr<TextureMapping2D> mapping_;
    const FloatTexture *around_, *dot_;
};

class SpectrumDots final : public SpectrumTexture {
  public:
    explicit SpectrumDots(const TextureArgs& args)
        : mapping_(MakeTextureMapping2D(args)),
          around_(SpectrumTextureParam(args.params, "inside", args.kind, 1, args.textures)),
          dot_(SpectrumTextureParam(args.params, "outside", args.kind, 0, args.textures)) {}
    SampledSpectrum Evaluate(const TextureContext& context, const SampledWavelengths& lambda) const override {
        return (InDot(mapping_->Map(context).st) ? dot_ : around_)->Evaluate(context, lambda);
    }

  private:
    std::unique_ptr<TextureMapping2D> mapping_;
    const SpectrumTexture *around_, *dot_;
};

std::unique_ptr<FloatTexture> CreateFloat(const TextureArgs& args) {
    return std::make_unique<FloatDots>(args);
}
std::unique_ptr<SpectrumTexture> CreateSpectrum(const TextureArgs& args) {
    return std::make_unique<SpectrumDots>(args);
}

}  // namespace

LACQUER_REGISTER(FloatTextureKind, "dots", CreateFloat);
LACQUER_REGISTER(SpectrumTextureKind, "dots", CreateSpectrum);

}  // namespace lacquer
