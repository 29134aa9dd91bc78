// Every light by itself in proportion to what it may bring to the point: slow with many lights, and what the
// tree of "bvh" approximates.
#include "pbrt/core/registry.h"
#include "pbrt/lights/light_bounds.h"
#include "pbrt/lights/light_index.h"

namespace lacquer {

namespace {

class ExhaustiveLightSampler final : public LightSampler {
  public:
    explicit ExhaustiveLightSampler(const std::vector<const Light*>& lights);
    std::optional<SampledLight> Sample(const LightReference& ref, float u) const override;
    float Pmf(const LightReference& ref, const Light* light) const override;

  private:
    float PDistant() const {
        return distant_.empty() ? 0.f : 1 / (float(distant_.size()) + (near_.empty() ? 0.f : 1.f));
    }
    float PNear() const { return distant_.empty() ? 1.f : PDistant(); }
    double Total(const LightReference& ref) const;

    std::vector<const Light*> near_, distant_;
    LightIndex nearIndex_, distantIndex_;
    std::vector<LightCluster> clusters_;  // of near_
};

ExhaustiveLightSampler::ExhaustiveLightSampler(const std::vector<const Light*>& lights) {
    float total = 0;
    for (const Light* light : lights) total += std::min(light->Power(), 1e25f);
    for (const Light* light : lights) {
        std::optional<LightBounds> bounds = light->Bounds();
        if (!(light->Power() > 0)) continue;
        (bounds ? near_ : distant_).push_back(light);
        if (!bounds) continue;
        bounds->power = std::min(bounds->power, 1e25f);
        clusters_.emplace_back(*bounds, total);
    }
    nearIndex_ = LightIndex(near_);
    distantIndex_ = LightIndex(distant_);
}

double ExhaustiveLightSampler::Total(const LightReference& ref) const {
    double total = 0;
    for (const LightCluster& cluster : clusters_) total += double(Importance(cluster, ref));
    return total;
}

std::optional<SampledLight> ExhaustiveLightSampler::Sample(const LightReference& ref, float u) const {
    if (!distant_.empty()) {
        const float scaled = u / PDistant();
        const size_t i = std::min(size_t(scaled), distant_.size() - (near_.empty() ? 1 : 0));
        if (i < distant_.size()) return SampledLight{distant_[i], PDistant()};
        u = std::min(scaled - float(distant_.size()), OneMinusEpsilon);
    }
    const double total = Total(ref);
    if (!(total > 0)) return std::nullopt;
    double below = 0;
    size_t chosen = 0;
    float importance = 0;
    for (size_t i = 0; i < clusters_.size() && below <= double(u) * total; ++i) {
        const float own = Importance(clusters_[i], ref);
        if (!(own > 0)) continue;
        below += double(own);
        chosen = i;
        importance = own;
    }
    return SampledLight{near_[chosen], PNear() * float(double(importance) / total)};
}

float ExhaustiveLightSampler::Pmf(const LightReference& ref, const Light* light) const {
    if (distantIndex_.Find(light) != LightIndex::kNone) return PDistant();
    const uint32_t i = nearIndex_.Find(light);
    if (i == LightIndex::kNone) return 0;
    const double total = Total(ref);
    return total > 0 ? PNear() * float(double(Importance(clusters_[i], ref)) / total) : 0.f;
}

std::unique_ptr<LightSampler> CreateExhaustiveSampler(std::span<const Light* const> lights) {
    return std::make_unique<ExhaustiveLightSampler>(SampledLights(lights));
}

}  // namespace

LACQUER_REGISTER(LightSamplerKind, "exhaustive", CreateExhaustiveSampler);

}  // namespace lacquer
