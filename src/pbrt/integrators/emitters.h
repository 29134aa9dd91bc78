// Lights to begin paths at.
#pragma once

#include "pbrt/core/sampling.h"
#include "pbrt/lights/light_index.h"

namespace lacquer {

/// All lights in proportion to their power, uniform infinite ones included, which light samplers leave out.
class EmitterTable {
  public:
    explicit EmitterTable(std::span<const Light* const> lights)
        : lights_(lights.begin(), lights.end()), index_(lights_) {
        std::vector<float> powers;
        for (const Light* light : lights_) powers.push_back(light->Power());
        table_ = AliasTable(powers);
    }

    /// Empty if there is none.
    std::optional<SampledLight> Sample(float u) const {
        if (lights_.empty()) return std::nullopt;
        float pmf = 0;
        const int i = table_.Sample(u, &pmf);
        return SampledLight{lights_[size_t(i)], pmf};
    }
    float Pmf(const Light* light) const {
        const uint32_t i = index_.Find(light);
        return i == LightIndex::kNone ? 0.f : table_.Pmf(int(i));
    }

  private:
    std::vector<const Light*> lights_;
    LightIndex index_;
    AliasTable table_;
};

}  // namespace lacquer
