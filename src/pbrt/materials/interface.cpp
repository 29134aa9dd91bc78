// Material "interface": no surface, only a boundary between media. Its parameters are not checked.
#include "pbrt/base/material.h"

namespace lacquer {
namespace {

class InterfaceMaterial final : public Material {
  public:
    BxDF* MakeBxDF(const TextureContext&, SampledWavelengths&, Arena&) const override { return nullptr; }
    bool Transmits() const override { return true; }
    bool IsInvisible() const override { return true; }
    bool NeedsFootprint() const override { return false; }
};

std::unique_ptr<Material> CreateInterface(const MaterialArgs& args) {
    for (const Parameter& parameter : args.params.All()) args.params.Ignore(parameter.type, parameter.name);
    return std::make_unique<InterfaceMaterial>();
}

}  // namespace

LACQUER_REGISTER(MaterialKind, "interface", CreateInterface);

}  // namespace lacquer
