// From a light to its place in a list.
#pragma once

#include <span>
#include <vector>

#include "pbrt/base/light.h"
#include "pbrt/core/rng.h"

namespace lacquer {

/// Finds the index of a light by its address: a few comparisons in small scenes, else an open hash table that
/// is at most half full, so that a look-up touches one or two cache lines. Immutable after its construction.
class LightIndex {
  public:
    static constexpr uint32_t kNone = ~uint32_t(0);

    LightIndex() = default;
    explicit LightIndex(std::span<const Light* const> lights) {
        size_t size = 1;
        while (size < 2 * lights.size()) size *= 2;
        if (lights.size() <= kScanned) size = lights.size();
        slots_.resize(size);
        for (size_t i = 0; i < lights.size(); ++i) Insert(lights[i], uint32_t(i));
    }
    /// Position of `light` in the list, kNone if it is not there.
    uint32_t Find(const Light* light) const {
        if (slots_.size() <= kScanned) {
            for (const Slot& slot : slots_)
                if (slot.light == light) return slot.index;
            return kNone;
        }
        for (size_t i = Home(light);; i = (i + 1) & (slots_.size() - 1))
            if (slots_[i].light == light || !slots_[i].light) return slots_[i].index;
    }

  private:
    static constexpr size_t kScanned = 8;
    struct Slot {
        const Light* light = nullptr;
        uint32_t index = kNone;
    };
    size_t Home(const Light* light) const { return Hash(light) & (slots_.size() - 1); }
    void Insert(const Light* light, uint32_t index) {
        size_t i = slots_.size() <= kScanned ? index : Home(light);
        while (slots_[i].light) i = (i + 1) & (slots_.size() - 1);
        slots_[i] = {light, index};
    }
    std::vector<Slot> slots_;
};

/// The lights that samplers choose among: all but uniform infinite ones, which scattered rays find by
/// themselves.
inline std::vector<const Light*> SampledLights(std::span<const Light* const> lights) {
    std::vector<const Light*> result;
    for (const Light* light : lights)
        if (!light->IsUniformInfinite()) result.push_back(light);
    return result;
}

}  // namespace lacquer
