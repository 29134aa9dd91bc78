// Material "example", with a BxDF that nothing else uses: a white mirror.
//   share    float texture    1    of the light that comes back
// Stands in src/pbrt/materials. Scene: Material "example" "texture share" "t"
#include "pbrt/base/material.h"

namespace lacquer {
namespace {

class ExampleBxDF final : public BxDF {
  public:
    explicit ExampleBxDF(float share) : share_(share) {}
    Lobes Flags() const override { return Lobes::SpecularReflection; }
    BxDFValue Evaluate(Vec3, Vec3, const BxDFContext&) const override { return {}; }
    std::optional<BxDFSample> Sample(Vec3 wo, const BxDFRandom&, const BxDFContext& context) const override {
        if (!Any(context.sides, Lobes::Reflection)) return std::nullopt;
        return BxDFSample{.wi = {-wo.x, -wo.y, wo.z},
                          .weight = SampledSpectrum(share_),
                          .pdf = 1,
                          .lobe = Lobes::SpecularReflection};
    }

  private:
    float share_;
};

class Example final : public Material {
  public:
    explicit Example(const FloatTexture* share) : share_(share) {}
    BxDF* MakeBxDF(const TextureContext& context, SampledWavelengths&, Arena& arena) const override {
        return arena.New<ExampleBxDF>(share_->Evaluate(context));
    }

  private:
    const FloatTexture* share_;
};

std::unique_ptr<Material> Create(const MaterialArgs& args) {
    return std::make_unique<Example>(FloatTextureParam(args.params, "share", 1, args.textures));
}

}  // namespace

LACQUER_REGISTER(MaterialKind, "example", Create);

}  // namespace lacquer
