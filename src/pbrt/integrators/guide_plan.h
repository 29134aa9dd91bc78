// Which samples of an image a guide learns from.
#pragma once

#include <cstdint>

#include "pbrt/core/rng.h"
#include "pbrt/core/vec.h"

namespace lacquer {

/// One pixel in each block of the whole image, and its first samples, in passes of 1, 1, 2, 4, ... of them:
/// of at most an eighth of the image's samples. A function of the image alone, whatever part of it is
/// rendered.
class GuidePlan {
  public:
    /// @param samples  of each pixel
    GuidePlan(Int2 resolution, int samples);

    /// In pixels that stand for blocks.
    const Bounds2i& Blocks() const { return blocks_; }
    /// 0: there are too few samples to learn from.
    int NumPasses() const { return numPasses_; }
    /// Numbers of a pass's samples: [first, end).
    static int FirstSample(int pass) { return pass == 0 ? 0 : EndSample(pass - 1); }
    static int EndSample(int pass) { return 1 << pass; }
    /// Of all pixels, in the passes up to this one.
    int64_t SamplesUpTo(int pass) const { return int64_t(blocks_.Area()) * EndSample(pass); }
    /// Of all passes and pixels.
    int64_t NumSamples() const { return SamplesUpTo(numPasses_ - 1); }
    /// Samples of a pixel on average, in the passes up to this one.
    int SamplesOfPixel(int pass) const {
        return int(SamplesUpTo(pass) / (int64_t(resolution_.x) * resolution_.y));
    }
    /// Any pixel of a block, so that no pattern of the image hides from the guide.
    Int2 PixelIn(Int2 block, Rng rng) const;

  private:
    Int2 resolution_;
    int side_ = 1;  ///< of a block, in pixels
    Bounds2i blocks_;
    int numPasses_ = 0;
};

}  // namespace lacquer
