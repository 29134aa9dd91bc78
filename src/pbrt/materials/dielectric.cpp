// Material "dielectric": glass, water, and other transparent media.
//   eta              float or spectrum   1.5     index inside over index outside; one that varies disperses
//   roughness, uroughness, vroughness, remaproughness, distribution: see roughness.h
#include "pbrt/bxdfs/dielectric.h"
#include "pbrt/base/material.h"
#include "pbrt/materials/index_of_refraction.h"
#include "pbrt/materials/roughness.h"

namespace lacquer {
namespace {

class DielectricMaterial final : public Material {
  public:
    DielectricMaterial(IndexOfRefraction eta, const RoughnessTextures& roughness)
        : eta_(std::move(eta)), roughness_(roughness) {}

    BxDF* MakeBxDF(const TextureContext& context, SampledWavelengths& lambda,
                         Arena& arena) const override {
        return NewMicrofacetBxDF<DielectricBxDF>(roughness_.Model(), arena, roughness_.At(context),
                                                 eta_.At(lambda));
    }
    bool NeedsFootprint() const override { return HasBump() || !roughness_.IsConstant(); }

  private:
    IndexOfRefraction eta_;
    RoughnessTextures roughness_;
};

std::unique_ptr<Material> CreateDielectric(const MaterialArgs& args) {
    auto material = std::make_unique<DielectricMaterial>(IndexOfRefraction::Read(args.params),
                                                         RoughnessTextures::Read(args.params, args.textures));
    material->ReadBump(args.params, args.textures);
    return material;
}

}  // namespace

LACQUER_REGISTER(MaterialKind, "dielectric", CreateDielectric);

}  // namespace lacquer
