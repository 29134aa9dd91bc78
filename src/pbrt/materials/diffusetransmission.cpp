// Material "diffusetransmission": Lambertian reflection and transmission.
//
//   "spectrum texture reflectance"    0.25  of the side of the light
//   "spectrum texture transmittance"  0.25  to the other side
//   "float scale"                     1     multiplies both, which are then clamped to [0, 1]
//   "displacement", "normalmap", "rotation": see Material::ReadBump()
#include "pbrt/base/material.h"
#include "pbrt/bxdfs/diffuse_transmission.h"

namespace lacquer {
namespace {

class DiffuseTransmissionMaterial final : public Material {
  public:
    DiffuseTransmissionMaterial(const SpectrumTexture* reflectance, const SpectrumTexture* transmittance,
                                float scale)
        : reflectance_(reflectance), transmittance_(transmittance), scale_(scale) {}

    BxDF* MakeBxDF(const TextureContext& context, SampledWavelengths& lambda, Arena& arena) const override {
        return arena.New<DiffuseTransmissionBxDF>(
            Clamp(reflectance_->Evaluate(context, lambda) * scale_, 0, 1),
            Clamp(transmittance_->Evaluate(context, lambda) * scale_, 0, 1));
    }
    bool Transmits() const override { return true; }
    bool NeedsFootprint() const override {
        return HasBump() || !reflectance_->IsConstant() || !transmittance_->IsConstant();
    }

  private:
    const SpectrumTexture* reflectance_;
    const SpectrumTexture* transmittance_;
    float scale_;
};

std::unique_ptr<Material> CreateDiffuseTransmission(const MaterialArgs& args) {
    const auto albedo = [&](const char* name) {
        return SpectrumTextureParam(args.params, name, SpectrumKind::Albedo, 0.25f, args.textures);
    };
    auto material = std::make_unique<DiffuseTransmissionMaterial>(
        albedo("reflectance"), albedo("transmittance"), args.params.GetFloat("scale", 1));
    material->ReadBump(args.params, args.textures);
    return material;
}

}  // namespace

LACQUER_REGISTER(MaterialKind, "diffusetransmission", CreateDiffuseTransmission);

}  // namespace lacquer
