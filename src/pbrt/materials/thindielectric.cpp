// Material "thindielectric": a thin sheet of glass, always smooth.
//   eta              float or spectrum   1.5     index of the sheet over index around it
#include "pbrt/base/material.h"
#include "pbrt/bxdfs/thin_dielectric.h"
#include "pbrt/materials/index_of_refraction.h"

namespace lacquer {
namespace {

class ThinDielectricMaterial final : public Material {
  public:
    explicit ThinDielectricMaterial(IndexOfRefraction eta) : eta_(std::move(eta)) {}

    BxDF* MakeBxDF(const TextureContext&, SampledWavelengths& lambda, Arena& arena) const override {
        return arena.New<ThinDielectricBxDF>(eta_.At(lambda));
    }
    bool Transmits() const override { return true; }
    bool NeedsFootprint() const override { return HasBump(); }

  private:
    IndexOfRefraction eta_;
};

std::unique_ptr<Material> CreateThinDielectric(const MaterialArgs& args) {
    auto material = std::make_unique<ThinDielectricMaterial>(IndexOfRefraction::Read(args.params));
    material->ReadBump(args.params, args.textures);
    return material;
}

}  // namespace

LACQUER_REGISTER(MaterialKind, "thindielectric", CreateThinDielectric);

}  // namespace lacquer
