// How alike the surroundings of two pixels are: weights of non-local means for images with known noise
// [Rousselle et al. 2012].
#pragma once

#include <vector>

#include "denoise/planes.h"

namespace lacquer::denoise {

/// What patches are compared in.
template <size_t N>
struct Guide {
    const Planes<N>& values;
    const Planes<N>& variances;  ///< of the values
};

struct PatchOptions {
    int windowRadius = 9;
    int patchRadius = 3;
    float bandwidth = 0.5f;  ///< k: differences of this many deviations are different
};

/// Weights of all pixels of a window around the pixels of a tile. Pixels outside of the image weigh 0.
class PatchWeights {
  public:
    /// @param tile  inside of the image
    template <size_t N>
    PatchWeights(const Guide<N>& guide, const Bounds2i& tile, const PatchOptions& options);

    int WindowRadius() const { return radius_; }
    /// Of the pixel at `p + offset` for the pixel p of the tile: in [0, 1], 1 for the pixel itself.
    float At(Int2 p, Int2 offset) const {
        const int side = 2 * radius_ + 1;
        const size_t plane = size_t(offset.y + radius_) * size_t(side) + size_t(offset.x + radius_);
        const size_t pixel = size_t(p.y - tile_.min.y) * size_t(tile_.Width()) + size_t(p.x - tile_.min.x);
        return weights_[plane * size_t(tile_.Area()) + pixel];
    }

  private:
    Bounds2i tile_;
    int radius_;
    std::vector<float> weights_;  ///< [offset][pixel of the tile]
};

extern template PatchWeights::PatchWeights(const Guide<3>&, const Bounds2i&, const PatchOptions&);
extern template PatchWeights::PatchWeights(const Guide<kNumFeatures>&, const Bounds2i&, const PatchOptions&);

}  // namespace lacquer::denoise
