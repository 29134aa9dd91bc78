// Material "dielectric": glass, water, and other transparent media.
//
//   "float eta" or "spectrum eta"  1.5  index inside over index outside; one that varies with wavelength
//                                       disperses. In a stack, if not given: as the media on its two sides
//                                       have it
//   "roughness", "uroughness", "vroughness", "remaproughness", "distribution": see roughness.h
//   "bool multiscatter"            false  also light that meets several facets of the rough surface
//   "displacement", "normalmap", "rotation": see Material::ReadBump()
#include "pbrt/bxdfs/dielectric.h"
#include "pbrt/base/material.h"
#include "pbrt/base/stack_boundary.h"
#include "pbrt/bxdfs/multiscatter_dielectric.h"
#include "pbrt/materials/index_of_refraction.h"
#include "pbrt/materials/parts.h"

namespace lacquer {
namespace {

class DielectricMaterial final : public Material, public StackBoundary {
  public:
    /// Without an index of its own, and with nothing around that says it, it has `eta` as well.
    DielectricMaterial(IndexOfRefraction eta, bool hasOwnIndex, const RoughnessTextures& roughness,
                       bool multiscatter)
        : eta_(std::move(eta)),
          hasOwnIndex_(hasOwnIndex),
          roughness_(roughness),
          multiscatter_(multiscatter) {}

    BxDF* MakeBxDF(const TextureContext& context, SampledWavelengths& lambda, Arena& arena) const override {
        return Make(context, arena, eta_.At(lambda));
    }
    BxDF* MakeBoundary(const TextureContext& context, SampledWavelengths& lambda, Arena& arena,
                       const BoundaryMedia& media) const override {
        return Make(context, arena, EtaAcross(lambda, media));
    }
    float EtaAcross(SampledWavelengths& lambda, const BoundaryMedia& media) const override {
        if (hasOwnIndex_ || !media.etaBelow) return eta_.At(lambda);
        return IndexOfRefraction::Limited(*media.etaBelow / media.etaAbove);
    }
    bool Transmits() const override { return true; }
    bool NeedsFootprint() const override { return HasBump() || !roughness_.IsConstant(); }

  private:
    BxDF* Make(const TextureContext& context, Arena& arena, float eta) const {
        const Alphas alphas = roughness_.At(context);
        if (multiscatter_ && !alphas.IsSmooth() && eta != 1)
            return NewMicrofacetBxDF<MultiscatterDielectricBxDF>(roughness_.Model(), arena, alphas, eta);
        return NewMicrofacetBxDF<DielectricBxDF>(roughness_.Model(), arena, alphas, eta);
    }

    IndexOfRefraction eta_;
    bool hasOwnIndex_;
    RoughnessTextures roughness_;
    bool multiscatter_;
};

std::unique_ptr<Material> CreateDielectric(const MaterialArgs& args) {
    auto material = std::make_unique<DielectricMaterial>(
        IndexOfRefraction::Read(args.params), args.params.Has("eta"),
        RoughnessTextures::Read(args.params, args.textures), args.params.GetBool("multiscatter", false));
    material->ReadBump(args.params, args.textures);
    return material;
}

}  // namespace

std::unique_ptr<Material> MakeDielectricPart(const RoughnessTextures& roughness, bool multiscatter) {
    return std::make_unique<DielectricMaterial>(IndexOfRefraction(), false, roughness, multiscatter);
}

LACQUER_REGISTER(MaterialKind, "dielectric", CreateDielectric);

}  // namespace lacquer
