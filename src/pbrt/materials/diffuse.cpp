// Material "diffuse": Lambertian reflection.
//
//   "spectrum texture reflectance"  0.5  clamped to [0, 1]
//   "displacement", "normalmap", "rotation": see Material::ReadBump()
#include "pbrt/bxdfs/diffuse.h"
#include "pbrt/materials/parts.h"

namespace lacquer {
namespace {

class DiffuseMaterial final : public Material {
  public:
    explicit DiffuseMaterial(const SpectrumTexture* reflectance) : reflectance_(reflectance) {}

    BxDF* MakeBxDF(const TextureContext& context, SampledWavelengths& lambda, Arena& arena) const override {
        return arena.New<DiffuseBxDF>(Clamp(reflectance_->Evaluate(context, lambda), 0, 1));
    }
    bool NeedsFootprint() const override { return HasBump() || !reflectance_->IsConstant(); }

  private:
    const SpectrumTexture* reflectance_;
};

std::unique_ptr<Material> CreateDiffuse(const MaterialArgs& args) {
    auto material = MakeDiffusePart(args.params, args.textures);
    material->ReadBump(args.params, args.textures);
    return material;
}

}  // namespace

std::unique_ptr<Material> MakeDiffusePart(const Params& params, TextureLibrary& textures) {
    return std::make_unique<DiffuseMaterial>(
        SpectrumTextureParam(params, "reflectance", SpectrumKind::Albedo, 0.5f, textures));
}

LACQUER_REGISTER(MaterialKind, "diffuse", CreateDiffuse);

}  // namespace lacquer
