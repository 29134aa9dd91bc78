// Texture "directionmix": a tex1 + (1 - a) tex2 with a = |n . dir|. That tex1 shows where the normal lies
// along dir, unlike in "mix", is the convention of pbrt.
//
//   "float texture tex1", "spectrum texture tex1"  0
//   "float texture tex2", "spectrum texture tex2"  1
//   "vector3 dir"                                  0 1 0  in texture space
#include "pbrt/base/texture.h"
#include "pbrt/textures/finite_params.h"

namespace lacquer {

namespace {

/// |n . direction|. The normal is that of the geometry, as in pbrt: on a mesh with normals of its own the
/// texture shows its faces.
float Alignment(const TextureContext& context, Vec3 direction) {
    return AbsDot(context.surface ? context.surface->n : context.n, direction);
}

class FloatDirectionMix final : public FloatTexture {
  public:
    FloatDirectionMix(const FloatTexture* texture1, const FloatTexture* texture2, Vec3 direction)
        : texture1_(texture1), texture2_(texture2), direction_(direction) {}
    float Evaluate(const TextureContext& context) const override {
        const float a = Alignment(context, direction_);
        return a * texture1_->Evaluate(context) + (1 - a) * texture2_->Evaluate(context);
    }

  private:
    const FloatTexture *texture1_, *texture2_;
    Vec3 direction_;
};

class SpectrumDirectionMix final : public SpectrumTexture {
  public:
    SpectrumDirectionMix(const SpectrumTexture* texture1, const SpectrumTexture* texture2, Vec3 direction)
        : texture1_(texture1), texture2_(texture2), direction_(direction) {}
    SampledSpectrum Evaluate(const TextureContext& context, const SampledWavelengths& lambda) const override {
        const float a = Alignment(context, direction_);
        return a * texture1_->Evaluate(context, lambda) + (1 - a) * texture2_->Evaluate(context, lambda);
    }

  private:
    const SpectrumTexture *texture1_, *texture2_;
    Vec3 direction_;
};

/// `dir` (default y) in rendering space, unit.
Vec3 ReadDirection(const TextureArgs& args) {
    const Vec3 direction =
        Normalize(args.renderFromTexture.Vector(FiniteVector3(args.params, "dir", {0, 1, 0})));
    if (!IsFinite(direction)) args.params.Fail("dir", "\"vector3 dir\" must not be zero");
    return direction;
}

std::unique_ptr<FloatTexture> CreateFloat(const TextureArgs& args) {
    return std::make_unique<FloatDirectionMix>(FloatTextureParam(args.params, "tex1", 0, args.textures),
                                               FloatTextureParam(args.params, "tex2", 1, args.textures),
                                               ReadDirection(args));
}

std::unique_ptr<SpectrumTexture> CreateSpectrum(const TextureArgs& args) {
    return std::make_unique<SpectrumDirectionMix>(
        SpectrumTextureParam(args.params, "tex1", args.kind, 0, args.textures),
        SpectrumTextureParam(args.params, "tex2", args.kind, 1, args.textures), ReadDirection(args));
}

}  // namespace

LACQUER_REGISTER(FloatTextureKind, "directionmix", CreateFloat);
LACQUER_REGISTER(SpectrumTextureKind, "directionmix", CreateSpectrum);

}  // namespace lacquer
