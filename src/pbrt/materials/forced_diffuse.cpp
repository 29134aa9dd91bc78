#include "pbrt/materials/forced_diffuse.h"

#include "pbrt/bxdfs/forced_diffuse.h"

namespace lacquer {

namespace {

class MatteMaterial final : public Material {
  public:
    /// The base's copy takes over what bumps the surface.
    MatteMaterial(const Material& original, std::shared_ptr<const MatteCounterparts> counterparts)
        : Material(original), original_(original), counterparts_(std::move(counterparts)) {}

    BxDF* MakeBxDF(const TextureContext& context, SampledWavelengths& lambda, Arena& arena) const override {
        const BxDF* model = original_.MakeBxDF(context, lambda, arena);
        return model ? arena.New<ForcedDiffuseBxDF>(model) : nullptr;
    }
    const Material* Choose(const TextureContext& context, Vec3 wo) const override {
        return counterparts_->at(original_.Choose(context, wo));
    }
    std::string WhyNotASurface() const override { return original_.WhyNotASurface(); }
    bool NeedsFootprint() const override { return original_.NeedsFootprint(); }

  private:
    const Material& original_;
    std::shared_ptr<const MatteCounterparts> counterparts_;
};

}  // namespace

std::shared_ptr<const MatteCounterparts> AddMatteCounterparts(
    std::vector<std::unique_ptr<Material>>* materials) {
    const auto counterparts = std::make_shared<MatteCounterparts>();
    const size_t count = materials->size();
    for (size_t i = 0; i < count; ++i) {
        const Material* original = (*materials)[i].get();
        if (original->IsInvisible()) continue;
        materials->push_back(std::make_unique<MatteMaterial>(*original, counterparts));
        counterparts->emplace(original, materials->back().get());
    }
    return counterparts;
}

}  // namespace lacquer
