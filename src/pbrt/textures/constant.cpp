// Texture "constant": the same value everywhere.
//
//   "float value", "spectrum value"  1
#include "pbrt/base/constant_texture.h"
#include "pbrt/textures/finite_params.h"

namespace lacquer {

namespace {

std::unique_ptr<FloatTexture> CreateFloat(const TextureArgs& args) {
    return std::make_unique<FloatConstantTexture>(FiniteFloat(args.params, "value", 1));
}

std::unique_ptr<SpectrumTexture> CreateSpectrum(const TextureArgs& args) {
    std::unique_ptr<Spectrum> value = args.params.GetSpectrum("value", args.kind);
    if (!value) value = std::make_unique<ConstantSpectrum>(1.f);
    return std::make_unique<SpectrumConstantTexture>(std::move(value));
}

}  // namespace

LACQUER_REGISTER(FloatTextureKind, "constant", CreateFloat);
LACQUER_REGISTER(SpectrumTextureKind, "constant", CreateSpectrum);

}  // namespace lacquer
