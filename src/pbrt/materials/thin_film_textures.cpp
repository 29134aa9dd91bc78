#include "pbrt/materials/thin_film_textures.h"

#include <fmt/format.h>

#include "pbrt/base/constant_texture.h"
#include "pbrt/materials/index_of_refraction.h"

namespace lacquer {
namespace {

constexpr float kDefaultEta = 1.4f, kMaxK = 1e6f;

/// `"float name"`, or what a spectrum can be given as; else the constant `fallback`.
const SpectrumTexture* IndexParam(const Params& params, const std::string& name, float fallback,
                                  bool canBeZero, TextureLibrary& textures) {
    const std::optional<float> number = params.GetOptionalFloat(name);
    if (!number) return SpectrumTextureParam(params, name, SpectrumKind::Unbounded, fallback, textures);
    if (*number < 0 || (*number == 0 && !canBeZero))
        params.Fail(name, fmt::format("\"{}\" is {}; expected a {}", name, *number,
                                      canBeZero ? "number that is not negative" : "positive number"));
    return textures.Own(
        std::make_unique<SpectrumConstantTexture>(std::make_unique<ConstantSpectrum>(*number)));
}

}  // namespace

void ThinFilmTextures::RequireThickness(const Params& params, const std::string& name) {
    if (!params.Has("thinfilm_thickness"))
        params.Fail(name, fmt::format("\"{}\" is given without \"thinfilm_thickness\", which is expected "
                                      "beside it, in nanometers",
                                      name));
}

ThinFilmTextures ThinFilmTextures::Read(const Params& params, TextureLibrary& textures) {
    ThinFilmTextures film;
    film.thickness_ = OptionalFloatTextureParam(params, "thinfilm_thickness", textures);
    if (!film.thickness_) {
        for (const char* name : {"thinfilm_eta", "thinfilm_k"})
            if (params.Has(name)) RequireThickness(params, name);
        return film;
    }
    const std::optional<float> thickness = film.thickness_->Constant();
    if (thickness && (*thickness < 0 || *thickness > kMaxFilmThickness))
        params.Fail("thinfilm_thickness",
                    fmt::format("\"thinfilm_thickness\" is {}; expected a number of nanometers from 0 to {}",
                                *thickness, kMaxFilmThickness));
    film.eta_ = IndexParam(params, "thinfilm_eta", kDefaultEta, false, textures);
    film.k_ = IndexParam(params, "thinfilm_k", 0, true, textures);
    return film;
}

std::optional<ThinFilm> ThinFilmTextures::At(const TextureContext& context, const SampledWavelengths& lambda,
                                             float etaAbove) const {
    if (!thickness_) return {};
    const float thickness = thickness_->Evaluate(context);
    if (!(thickness > 0)) return {};
    const SampledSpectrum eta = Map(eta_->Evaluate(context, lambda), IndexOfRefraction::Limited);
    const SampledSpectrum k = Clamp(k_->Evaluate(context, lambda), 0, kMaxK);
    return ThinFilm(std::min(thickness, kMaxFilmThickness), eta, k, lambda.Lambda(), etaAbove);
}

bool ThinFilmTextures::IsConstant() const {
    return !thickness_ || (thickness_->Constant() && eta_->IsConstant() && k_->IsConstant());
}

}  // namespace lacquer
