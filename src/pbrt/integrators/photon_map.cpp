#include "pbrt/integrators/photon_map.h"

#include <bit>
#include <numeric>

namespace lacquer {

PhotonMap::PhotonMap(std::vector<std::vector<Photon>> blocks, float radius)
    : radius_(radius), inverseWidth_(1 / (2 * radius)) {
    size_t count = 0;
    for (const auto& block : blocks) count += block.size();
    // About one photon a bucket.
    starts_.assign(std::bit_ceil(std::max<size_t>(count, 1)) + 1, 0);
    // A counting sort, which keeps the order within a bucket. `starts_` holds the ends while they are filled
    // from behind.
    for (const auto& block : blocks)
        for (const Photon& photon : block) ++starts_[BucketOf(CellOf(photon.p))];
    std::partial_sum(starts_.begin(), starts_.end(), starts_.begin());
    photons_.resize(count);
    for (; !blocks.empty(); blocks.pop_back()) {
        const auto& block = blocks.back();
        for (size_t i = block.size(); i-- > 0;) photons_[--starts_[BucketOf(CellOf(block[i].p))]] = block[i];
    }
}

}  // namespace lacquer
