// Lights in proportion to their power, wherever they are.
#include "pbrt/core/registry.h"
#include "pbrt/core/sampling.h"
#include "pbrt/lights/light_index.h"

namespace lacquer {

namespace {

std::vector<float> Powers(std::span<const Light* const> lights) {
    std::vector<float> powers;
    for (const Light* light : lights) powers.push_back(light->Power());
    return powers;
}

class PowerLightSampler final : public LightSampler {
  public:
    explicit PowerLightSampler(std::vector<const Light*> lights)
        : lights_(std::move(lights)), index_(lights_), table_(Powers(lights_)) {}

    std::optional<SampledLight> Sample(const LightReference&, float u) const override {
        if (lights_.empty()) return std::nullopt;
        if (lights_.size() == 1) return SampledLight{lights_[0], 1};
        float pmf = 0;
        const int i = table_.Sample(u, &pmf);
        return SampledLight{lights_[size_t(i)], pmf};
    }
    float Pmf(const LightReference&, const Light* light) const override {
        const uint32_t i = index_.Find(light);
        if (i == LightIndex::kNone) return 0;
        return lights_.size() == 1 ? 1.f : table_.Pmf(int(i));
    }

  private:
    std::vector<const Light*> lights_;
    LightIndex index_;
    AliasTable table_;
};

std::unique_ptr<LightSampler> CreatePowerSampler(std::span<const Light* const> lights) {
    return std::make_unique<PowerLightSampler>(SampledLights(lights));
}

}  // namespace

LACQUER_REGISTER(LightSamplerKind, "power", CreatePowerSampler);

}  // namespace lacquer
