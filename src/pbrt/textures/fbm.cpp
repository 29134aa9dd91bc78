// Texture "fbm": fractional Brownian motion, noise summed over octaves, of either sign.
//
//   "integer octaves", "float roughness"  8, 0.5  number of octaves, and the amplitude of one relative to the
//                                                 one before: see noise.h
#include "pbrt/textures/noise.h"
#include "pbrt/textures/texture_mapping.h"

namespace lacquer {

namespace {

class Fbm final : public FloatTexture {
  public:
    explicit Fbm(const TextureArgs& args) : mapping_(args), octaves_(OctaveParams::Read(args.params)) {}
    float Evaluate(const TextureContext& context) const override {
        const TexturePoint c = mapping_.Map(context);
        return FractionalBrownianMotion(c.p, c.dpdx, c.dpdy, octaves_);
    }

  private:
    TextureMapping3D mapping_;
    OctaveParams octaves_;
};

std::unique_ptr<FloatTexture> Create(const TextureArgs& args) { return std::make_unique<Fbm>(args); }

}  // namespace

LACQUER_REGISTER(FloatTextureKind, "fbm", Create);

}  // namespace lacquer
