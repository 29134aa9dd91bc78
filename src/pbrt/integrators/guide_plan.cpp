#include "pbrt/integrators/guide_plan.h"

#include <algorithm>

namespace lacquer {
namespace {

constexpr int64_t kMaxPixels = 1 << 16, kMaxSamples = 1 << 23;
constexpr int kMaxSide = 1 << 14;
/// One in so many samples is learned from. With 4, guides are a fifth better, and twice as much is done
/// without them.
constexpr int kLearnedPart = 8;
/// With fewer than that come to 16 samples a block, nothing that was learned is worth its time.
constexpr int kMinPasses = 5;

}  // namespace

GuidePlan::GuidePlan(Int2 resolution, int samples) : resolution_(resolution) {
    const int64_t most = std::min(kMaxSamples, int64_t(resolution.x) * resolution.y * samples / kLearnedPart);
    for (side_ = 1; side_ <= kMaxSide; ++side_) {
        blocks_ = {Int2(0), (resolution + (side_ - 1)) / side_};
        if (blocks_.Area() > kMaxPixels) continue;
        numPasses_ = 0;
        while (EndSample(numPasses_) <= samples && blocks_.Area() * int64_t(EndSample(numPasses_)) <= most)
            ++numPasses_;
        if (numPasses_ >= kMinPasses) return;
    }
    numPasses_ = 0;
}

Int2 GuidePlan::PixelIn(Int2 block, Rng rng) const {
    const int x = int(rng.UniformInt(uint32_t(side_)));
    const int y = int(rng.UniformInt(uint32_t(side_)));
    return glm::min(side_ * block + Int2(x, y), resolution_ - 1);
}

}  // namespace lacquer
