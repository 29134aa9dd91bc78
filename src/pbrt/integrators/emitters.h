// Lights to begin paths at.
#pragma once

#include "pbrt/core/sampling.h"
#include "pbrt/lights/light_index.h"
#include "pbrt/scene/light_media.h"
#include "pbrt/scene/scene.h"

namespace lacquer {

/// All lights in proportion to their power, uniform infinite ones included, which light samplers leave out.
class EmitterTable {
  public:
    explicit EmitterTable(const Scene& scene) : lights_(scene.Lights()), index_(lights_) {
        std::vector<float> powers;
        powers.reserve(lights_.size());
        for (const Light* light : lights_) powers.push_back(light->Power());
        table_ = AliasTable(powers);
        if (scene.HasMedia()) media_ = FindLightMedia(scene);
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
    /// Of a light of the table.
    LightMedia MediaOf(const Light* light) const {
        return media_.empty() ? LightMedia() : media_[index_.Find(light)];
    }

  private:
    std::vector<const Light*> lights_;
    LightIndex index_;
    AliasTable table_;
    std::vector<LightMedia> media_;  ///< empty in scenes without media
};

}  // namespace lacquer
