// Texture "windy": waves whose height follows a slowly varying wind. It has no parameters.
#include "pbrt/textures/noise.h"
#include "pbrt/textures/texture_mapping.h"

namespace lacquer {

namespace {

class Windy final : public FloatTexture {
  public:
    explicit Windy(const TextureArgs& args) : mapping_(args) {}
    float Evaluate(const TextureContext& context) const override {
        const TexturePoint c = mapping_.Map(context);
        const float wind = FractionalBrownianMotion(0.1f * c.p, 0.1f * c.dpdx, 0.1f * c.dpdy, {0.5f, 3});
        const float wave = FractionalBrownianMotion(c.p, c.dpdx, c.dpdy, {0.5f, 6});
        return std::abs(wind) * wave;
    }

  private:
    TextureMapping3D mapping_;
};

std::unique_ptr<FloatTexture> Create(const TextureArgs& args) { return std::make_unique<Windy>(args); }

}  // namespace

LACQUER_REGISTER(FloatTextureKind, "windy", Create);

}  // namespace lacquer
