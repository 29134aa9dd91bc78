// Material "measured": an opaque surface as a gonio-photometer measured it.
//
//   "string filename"  required  .bsdf file of the RGL material database
//   "displacement", "normalmap", "rotation": see Material::ReadBump()
#include "pbrt/bxdfs/measured.h"

#include "pbrt/base/material.h"

namespace lacquer {
namespace {

class MeasuredMaterial final : public Material {
  public:
    explicit MeasuredMaterial(std::shared_ptr<const MeasuredBrdf> brdf) : brdf_(std::move(brdf)) {}

    BxDF* MakeBxDF(const TextureContext&, SampledWavelengths& lambda, Arena& arena) const override {
        return arena.New<MeasuredBxDF>(*brdf_, lambda);
    }
    bool NeedsFootprint() const override { return HasBump(); }

  private:
    std::shared_ptr<const MeasuredBrdf> brdf_;
};

std::unique_ptr<Material> CreateMeasured(const MaterialArgs& args) {
    const Params& params = args.params;
    const std::string filename = params.GetString("filename", "");
    if (filename.empty())
        params.Fail("filename", "the material needs \"string filename\": a measured BRDF (.bsdf)");
    auto material = std::make_unique<MeasuredMaterial>(
        MeasuredBrdf::Read(params.PathOf("filename"), params.LocOf("filename")));
    material->ReadBump(params, args.textures);
    return material;
}

}  // namespace

LACQUER_REGISTER(MaterialKind, "measured", CreateMeasured);

}  // namespace lacquer
