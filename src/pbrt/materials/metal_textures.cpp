#include "pbrt/materials/metal_textures.h"

#include <fmt/format.h>

#include "pbrt/base/constant_texture.h"
#include "pbrt/core/check.h"

namespace lacquer {
namespace {

/// A built-in table.
const SpectrumTexture* BuiltIn(const std::string& name, TextureLibrary& textures) {
    std::unique_ptr<Spectrum> spectrum = NamedSpectrum(name);
    LACQUER_CHECK(spectrum);
    return textures.Own(std::make_unique<SpectrumConstantTexture>(std::move(spectrum)));
}

}  // namespace

MetalTextures MetalTextures::Read(const Params& params, TextureLibrary& textures, const std::string& prefix,
                                  const std::string& metal) {
    MetalTextures result;
    result.eta_ = OptionalSpectrumTextureParam(params, prefix + "eta", SpectrumKind::Unbounded, textures);
    result.k_ = OptionalSpectrumTextureParam(params, prefix + "k", SpectrumKind::Unbounded, textures);
    result.reflectance_ = OptionalSpectrumTextureParam(params, "reflectance", SpectrumKind::Albedo, textures);
    if (result.reflectance_) {
        if (result.eta_ || result.k_)
            params.Fail(
                "reflectance",
                fmt::format("a metal has either \"reflectance\" or \"{0}eta\" and \"{0}k\"; expected only "
                            "one of the two",
                            prefix));
        return result;
    }
    if (!result.eta_) result.eta_ = BuiltIn("metal-" + metal + "-eta", textures);
    if (!result.k_) result.k_ = BuiltIn("metal-" + metal + "-k", textures);
    return result;
}

MetalTextures::Index MetalTextures::At(const TextureContext& context, const SampledWavelengths& lambda,
                                       float etaAbove) const {
    Index index;
    if (reflectance_) {
        // The k of a metal with eta = 1 and this reflectance at normal incidence: r = k^2 / (4 + k^2).
        const SampledSpectrum r = Clamp(reflectance_->Evaluate(context, lambda), 0, 0.9999f);
        index.k = 2 * Sqrt(r / (SampledSpectrum(1) - r));
    } else {
        index.eta = Clamp(eta_->Evaluate(context, lambda), 0, 1e6f);
        index.k = Clamp(k_->Evaluate(context, lambda), 0, 1e6f);
    }
    index.eta /= etaAbove;
    index.k /= etaAbove;
    return index;
}

bool MetalTextures::IsConstant() const {
    return reflectance_ ? reflectance_->IsConstant() : eta_->IsConstant() && k_->IsConstant();
}

}  // namespace lacquer
