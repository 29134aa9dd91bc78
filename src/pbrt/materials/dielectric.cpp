// Material "dielectric": glass, water, and other transparent media.
//
//   "float eta" or "spectrum eta"  1.5  index inside over index outside; one that varies with wavelength
//                                       disperses. In a stack, if not given: as the media on its two sides
//                                       have it
//   "roughness", "uroughness", "vroughness", "remaproughness", "distribution": see roughness.h
//   "bool multiscatter"            false  also light that meets several facets of the rough surface
//   "thinfilm_thickness", "thinfilm_eta", "thinfilm_k": a film on it, see thin_film_textures.h; not with
//   multiscatter "displacement", "normalmap", "rotation": see Material::ReadBump()
#include "pbrt/bxdfs/dielectric.h"
#include "pbrt/base/material.h"
#include "pbrt/base/stack_boundary.h"
#include "pbrt/bxdfs/multiscatter_dielectric.h"
#include "pbrt/materials/index_of_refraction.h"
#include "pbrt/materials/parts.h"
#include "pbrt/materials/thin_film_textures.h"

namespace lacquer {
namespace {

class DielectricMaterial final : public Material, public StackBoundary {
  public:
    /// Without an index of its own, and with nothing around that says it, it has `eta` as well.
    DielectricMaterial(IndexOfRefraction eta, bool hasOwnIndex, const RoughnessTextures& roughness,
                       const ThinFilmTextures& film, bool multiscatter)
        : eta_(std::move(eta)),
          hasOwnIndex_(hasOwnIndex),
          roughness_(roughness),
          film_(film),
          multiscatter_(multiscatter) {}

    BxDF* MakeBxDF(const TextureContext& context, SampledWavelengths& lambda, Arena& arena) const override {
        const float eta = eta_.At(lambda);
        return Make(context, lambda, arena, eta, 1);
    }
    BxDF* MakeBoundary(const TextureContext& context, SampledWavelengths& lambda, Arena& arena,
                       const BoundaryMedia& media) const override {
        const float eta = EtaAcross(lambda, media);
        return Make(context, lambda, arena, eta, media.etaAbove);
    }
    float EtaAcross(SampledWavelengths& lambda, const BoundaryMedia& media) const override {
        if (hasOwnIndex_ || !media.etaBelow) return eta_.At(lambda);
        return IndexOfRefraction::Limited(*media.etaBelow / media.etaAbove);
    }
    bool Transmits() const override { return true; }
    bool NeedsFootprint() const override {
        return HasBump() || !roughness_.IsConstant() || !film_.IsConstant();
    }

  private:
    /// @param lambda  after those that dispersion ends
    BxDF* Make(const TextureContext& context, const SampledWavelengths& lambda, Arena& arena, float eta,
               float etaAbove) const {
        const Alphas alphas = roughness_.At(context);
        if (const std::optional<ThinFilm> film = film_.At(context, lambda, etaAbove))
            return NewMicrofacetBxDF<FilmedDielectricBxDF>(roughness_.Model(), arena, alphas,
                                                           FilmedDielectric(eta, *film));
        if (multiscatter_ && !alphas.IsSmooth() && eta != 1)
            return NewMicrofacetBxDF<MultiscatterDielectricBxDF>(roughness_.Model(), arena, alphas, eta);
        return NewMicrofacetBxDF<DielectricBxDF>(roughness_.Model(), arena, alphas, eta);
    }

    IndexOfRefraction eta_;
    bool hasOwnIndex_;
    RoughnessTextures roughness_;
    ThinFilmTextures film_;
    bool multiscatter_;
};

std::unique_ptr<Material> CreateDielectric(const MaterialArgs& args) {
    const bool multiscatter = args.params.GetBool("multiscatter", false);
    if (multiscatter && args.params.Has("thinfilm_thickness"))
        args.params.Fail("thinfilm_thickness",
                         "a \"dielectric\" has either a thin film or \"multiscatter\"; expected only one of "
                         "the two");
    auto material = std::make_unique<DielectricMaterial>(
        IndexOfRefraction::Read(args.params), args.params.Has("eta"),
        RoughnessTextures::Read(args.params, args.textures),
        ThinFilmTextures::Read(args.params, args.textures), multiscatter);
    material->ReadBump(args.params, args.textures);
    return material;
}

}  // namespace

std::unique_ptr<Material> MakeDielectricPart(const RoughnessTextures& roughness, bool multiscatter) {
    return std::make_unique<DielectricMaterial>(IndexOfRefraction(), false, roughness, ThinFilmTextures(),
                                                multiscatter);
}

LACQUER_REGISTER(MaterialKind, "dielectric", CreateDielectric);

}  // namespace lacquer
