// Material "conductor": metal.
//
//   "spectrum texture eta", "spectrum texture k"  metal-Cu-eta, metal-Cu-k  complex index of refraction
//   "spectrum texture reflectance"                -                         instead of eta and k: the
//                                                                           reflectance at normal incidence
//   "roughness", "uroughness", "vroughness", "remaproughness", "distribution": see roughness.h
//   "bool multiscatter"                           false                     also light that meets several
//                                                                           facets of the rough surface
//   "thinfilm_thickness", "thinfilm_eta", "thinfilm_k": a film on it, see thin_film_textures.h
//   "displacement", "normalmap", "rotation": see Material::ReadBump()
#include "pbrt/bxdfs/conductor.h"

#include <fmt/format.h>

#include "pbrt/base/constant_texture.h"
#include "pbrt/base/material.h"
#include "pbrt/base/stack_boundary.h"
#include "pbrt/bxdfs/multiscatter_conductor.h"
#include "pbrt/core/check.h"
#include "pbrt/materials/parts.h"

namespace lacquer {
namespace {

/// The default index: one of the built-in tables.
const SpectrumTexture* BuiltIn(const char* name, TextureLibrary& textures) {
    std::unique_ptr<Spectrum> spectrum = NamedSpectrum(name);
    LACQUER_CHECK(spectrum);
    return textures.Own(std::make_unique<SpectrumConstantTexture>(std::move(spectrum)));
}

class ConductorMaterial final : public Material, public StackBoundary {
  public:
    /// `reflectance` is null where eta and k are given, and the other way round.
    ConductorMaterial(const SpectrumTexture* eta, const SpectrumTexture* k,
                      const SpectrumTexture* reflectance, const RoughnessTextures& roughness,
                      const ThinFilmTextures& film, bool multiscatter)
        : eta_(eta),
          k_(k),
          reflectance_(reflectance),
          roughness_(roughness),
          film_(film),
          multiscatter_(multiscatter) {}

    BxDF* MakeBxDF(const TextureContext& context, SampledWavelengths& lambda, Arena& arena) const override {
        return MakeBoundary(context, lambda, arena, {});
    }
    /// The index above divides also what follows from a reflectance: under a coat the metal reflects less.
    BxDF* MakeBoundary(const TextureContext& context, SampledWavelengths& lambda, Arena& arena,
                       const BoundaryMedia& media) const override {
        SampledSpectrum eta(1), k;
        if (reflectance_) {
            // The k of a metal with eta = 1 and this reflectance at normal incidence: r = k^2 / (4 + k^2).
            const SampledSpectrum r = Clamp(reflectance_->Evaluate(context, lambda), 0, 0.9999f);
            k = 2 * Sqrt(r / (SampledSpectrum(1) - r));
        } else {
            eta = Clamp(eta_->Evaluate(context, lambda), 0, 1e6f);
            k = Clamp(k_->Evaluate(context, lambda), 0, 1e6f);
        }
        eta /= media.etaAbove;
        k /= media.etaAbove;
        const Alphas alphas = roughness_.At(context);
        const bool rescatters = multiscatter_ && !alphas.IsSmooth();
        const MicrofacetModel model = roughness_.Model();
        if (const std::optional<ThinFilm> film = film_.At(context, lambda, media.etaAbove)) {
            const FilmedMetal metal(eta, k, *film);
            return rescatters
                       ? NewMicrofacetBxDF<FilmedMultiscatterConductorBxDF>(model, arena, alphas, metal)
                       : NewMicrofacetBxDF<FilmedConductorBxDF>(model, arena, alphas, metal);
        }
        const BareMetal metal(eta, k);
        return rescatters ? NewMicrofacetBxDF<MultiscatterConductorBxDF>(model, arena, alphas, metal)
                          : NewMicrofacetBxDF<ConductorBxDF>(model, arena, alphas, metal);
    }
    bool NeedsFootprint() const override {
        const bool constant =
            reflectance_ ? reflectance_->IsConstant() : eta_->IsConstant() && k_->IsConstant();
        return HasBump() || !constant || !roughness_.IsConstant() || !film_.IsConstant();
    }

  private:
    const SpectrumTexture* eta_;
    const SpectrumTexture* k_;
    const SpectrumTexture* reflectance_;
    RoughnessTextures roughness_;
    ThinFilmTextures film_;
    bool multiscatter_;
};

std::unique_ptr<Material> CreateConductor(const MaterialArgs& args) {
    auto material =
        MakeConductorPart(args.params, args.textures, "", ThinFilmTextures::Read(args.params, args.textures));
    material->ReadBump(args.params, args.textures);
    return material;
}

}  // namespace

std::unique_ptr<Material> MakeConductorPart(const Params& params, TextureLibrary& textures,
                                            const std::string& prefix, const ThinFilmTextures& film) {
    const SpectrumTexture* eta =
        OptionalSpectrumTextureParam(params, prefix + "eta", SpectrumKind::Unbounded, textures);
    const SpectrumTexture* k =
        OptionalSpectrumTextureParam(params, prefix + "k", SpectrumKind::Unbounded, textures);
    const SpectrumTexture* reflectance =
        OptionalSpectrumTextureParam(params, "reflectance", SpectrumKind::Albedo, textures);
    if (reflectance && (eta || k))
        params.Fail(
            "reflectance",
            fmt::format(
                "a conductor has either \"reflectance\" or \"{0}eta\" and \"{0}k\"; expected only one "
                "of the two",
                prefix));
    if (!reflectance) {
        if (!eta) eta = BuiltIn("metal-Cu-eta", textures);
        if (!k) k = BuiltIn("metal-Cu-k", textures);
    }
    return std::make_unique<ConductorMaterial>(eta, k, reflectance,
                                               RoughnessTextures::Read(params, textures, prefix), film,
                                               params.GetBool("multiscatter", false));
}

LACQUER_REGISTER(MaterialKind, "conductor", CreateConductor);

}  // namespace lacquer
