// Material "svbrdf": what `lacquer capture` makes of photographs, a diffuse lobe under a GGX lobe with a
// coloured reflectance.
//
//   "spectrum texture albedo"    0.5   of the diffuse lobe, for the light that the other one lets through;
//                                      clamped to [0, 1]
//   "spectrum texture specular"  0.04  reflectance at normal incidence; clamped to [0, 1]
//   "float texture alpha"        0.25  of the GGX lobe, clamped to [0.001, 1]; below 0.035 the lobe fades
//                                      away
//   "bool conserve"              true  the diffuse lobe gets what Fresnel's factor leaves at both angles;
//                                      false: at normal incidence, as maps are fitted, and brighter than
//                                      white there is
//   "displacement", "normalmap", "rotation": see Material::ReadBump()
#include "pbrt/bxdfs/svbrdf.h"

#include "pbrt/base/material.h"

namespace lacquer {
namespace {

class SvbrdfMaterial final : public Material {
  public:
    SvbrdfMaterial(const SpectrumTexture* albedo, const SpectrumTexture* specular, const FloatTexture* alpha,
                   bool conserve)
        : albedo_(albedo), specular_(specular), alpha_(alpha), conserve_(conserve) {}

    BxDF* MakeBxDF(const TextureContext& context, SampledWavelengths& lambda, Arena& arena) const override {
        return arena.New<SvbrdfBxDF>(Clamp(albedo_->Evaluate(context, lambda), 0, 1),
                                     Clamp(specular_->Evaluate(context, lambda), 0, 1),
                                     alpha_->Evaluate(context), conserve_);
    }
    bool NeedsFootprint() const override {
        return HasBump() || !albedo_->IsConstant() || !specular_->IsConstant() || !alpha_->Constant();
    }

  private:
    const SpectrumTexture* albedo_;
    const SpectrumTexture* specular_;
    const FloatTexture* alpha_;
    bool conserve_;
};

std::unique_ptr<Material> CreateSvbrdf(const MaterialArgs& args) {
    const auto reflectance = [&](const char* name, float fallback) {
        return SpectrumTextureParam(args.params, name, SpectrumKind::Albedo, fallback, args.textures);
    };
    auto material = std::make_unique<SvbrdfMaterial>(
        reflectance("albedo", 0.5f), reflectance("specular", 0.04f),
        FloatTextureParam(args.params, "alpha", 0.25f, args.textures), args.params.GetBool("conserve", true));
    material->ReadBump(args.params, args.textures);
    return material;
}

}  // namespace

LACQUER_REGISTER(MaterialKind, "svbrdf", CreateSvbrdf);

}  // namespace lacquer
