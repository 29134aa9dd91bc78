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

#include "pbrt/base/material.h"
#include "pbrt/base/stack_boundary.h"
#include "pbrt/bxdfs/multiscatter_conductor.h"
#include "pbrt/materials/metal_textures.h"
#include "pbrt/materials/parts.h"

namespace lacquer {
namespace {

class ConductorMaterial final : public Material, public StackBoundary {
  public:
    ConductorMaterial(const MetalTextures& metal, const RoughnessTextures& roughness,
                      const ThinFilmTextures& film, bool multiscatter)
        : metal_(metal), roughness_(roughness), film_(film), multiscatter_(multiscatter) {}

    BxDF* MakeBxDF(const TextureContext& context, SampledWavelengths& lambda, Arena& arena) const override {
        return MakeBoundary(context, lambda, arena, {});
    }
    BxDF* MakeBoundary(const TextureContext& context, SampledWavelengths& lambda, Arena& arena,
                       const BoundaryMedia& media) const override {
        const auto [eta, k] = metal_.At(context, lambda, media.etaAbove);
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
        return HasBump() || !metal_.IsConstant() || !roughness_.IsConstant() || !film_.IsConstant();
    }

  private:
    MetalTextures metal_;
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
    return std::make_unique<ConductorMaterial>(MetalTextures::Read(params, textures, prefix, "Cu"),
                                               RoughnessTextures::Read(params, textures, prefix), film,
                                               params.GetBool("multiscatter", false));
}

LACQUER_REGISTER(MaterialKind, "conductor", CreateConductor);

}  // namespace lacquer
