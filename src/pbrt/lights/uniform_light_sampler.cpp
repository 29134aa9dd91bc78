// Every light with the same probability.
#include "pbrt/core/registry.h"
#include "pbrt/lights/light_index.h"

namespace lacquer {

namespace {

class UniformLightSampler final : public LightSampler {
  public:
    explicit UniformLightSampler(std::vector<const Light*> lights)
        : lights_(std::move(lights)), index_(lights_) {}

    std::optional<SampledLight> Sample(const LightReference&, float u) const override {
        if (lights_.empty()) return std::nullopt;
        const size_t i = std::min(size_t(u * float(lights_.size())), lights_.size() - 1);
        return SampledLight{lights_[i], 1 / float(lights_.size())};
    }
    float Pmf(const LightReference&, const Light* light) const override {
        return index_.Find(light) == LightIndex::kNone ? 0.f : 1 / float(lights_.size());
    }

  private:
    std::vector<const Light*> lights_;
    LightIndex index_;
};

std::unique_ptr<LightSampler> CreateUniformSampler(std::span<const Light* const> lights) {
    return std::make_unique<UniformLightSampler>(SampledLights(lights));
}

}  // namespace

LACQUER_REGISTER(LightSamplerKind, "uniform", CreateUniformSampler);

}  // namespace lacquer
