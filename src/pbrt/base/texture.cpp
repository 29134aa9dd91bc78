#include "pbrt/base/texture.h"

#include <cmath>

#include "pbrt/base/constant_texture.h"
#include "pbrt/image/image_cache.h"

namespace lacquer {

namespace {

/// True unless a value of `name` takes precedence over a texture of that name: what the directive says itself
/// comes before what it inherits by Attribute, the later before the earlier.
bool TextureComesFirst(const Params& params, std::string_view name) {
    const Parameter* inForce = nullptr;
    for (const Parameter& p : params.All())
        if (p.name == name && (!inForce || inForce->fromAttribute || !p.fromAttribute)) inForce = &p;
    return !inForce || inForce->type == "texture";
}

}  // namespace

const FloatTexture* OptionalFloatTextureParam(const Params& params, std::string_view name,
                                              TextureLibrary& textures) {
    if (TextureComesFirst(params, name))
        if (const auto texture = params.GetTextureName(name))
            return textures.Float(*texture, params.LocOf(name));
    const std::optional<float> value = params.GetOptionalFloat(name);
    if (!value) return nullptr;
    if (!std::isfinite(*value))
        params.Fail(name, "\"float " + std::string(name) + "\" must be a finite number");
    return textures.Own(std::make_unique<FloatConstantTexture>(*value));
}

const FloatTexture* FloatTextureParam(const Params& params, std::string_view name, float fallback,
                                      TextureLibrary& textures) {
    const FloatTexture* texture = OptionalFloatTextureParam(params, name, textures);
    return texture ? texture : textures.Own(std::make_unique<FloatConstantTexture>(fallback));
}

std::shared_ptr<const Image> ImageParam(const Params& params, std::string_view name,
                                        const ColorEncoding& encoding, TextureLibrary& textures) {
    auto image = textures.Images().Get(params.PathOf(name), encoding, params.LocOf(name));
    params.RecordImage(name, image->Resolution(), image->Pixels().size() * sizeof(float));
    return image;
}

const SpectrumTexture* OptionalSpectrumTextureParam(const Params& params, std::string_view name,
                                                    SpectrumKind kind, TextureLibrary& textures) {
    if (TextureComesFirst(params, name))
        if (const auto texture = params.GetTextureName(name))
            return textures.Spectrum(*texture, kind, params.LocOf(name));
    std::unique_ptr<Spectrum> spectrum = params.GetSpectrum(name, kind);
    if (!spectrum) return nullptr;
    return textures.Own(std::make_unique<SpectrumConstantTexture>(std::move(spectrum)));
}

const SpectrumTexture* SpectrumTextureParam(const Params& params, std::string_view name, SpectrumKind kind,
                                            float fallback, TextureLibrary& textures) {
    const SpectrumTexture* texture = OptionalSpectrumTextureParam(params, name, kind, textures);
    if (texture) return texture;
    return textures.Own(
        std::make_unique<SpectrumConstantTexture>(std::make_unique<ConstantSpectrum>(fallback)));
}

}  // namespace lacquer
