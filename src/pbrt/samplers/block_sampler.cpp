#include "pbrt/samplers/block_sampler.h"

namespace lacquer {

void BlockSampler::StartBlock(Int2 pixel, int first) {
    const bool isNewPixel = pixel != pixel_ || firstIndex_ < 0;
    pixel_ = pixel;
    firstIndex_ = first;
    blockTag_ += 2;
    if (!isNewPixel) return;
    ++pixelTag_;
    StartPixel();
}

void BlockSampler::Refill1D(int dimension, Entry& entry) {
    Fill1D(dimension, entry.x);
    entry.tag = blockTag_;
}

void BlockSampler::Refill2D(int dimension, Entry& entry) {
    Fill2D(dimension, entry.x, entry.y);
    entry.tag = blockTag_ + 1;
}

Point2 BlockSampler::Independent(int dimension) const {
    return Rng(Hash(pixel_.x, pixel_.y, firstIndex_ + int(lane_), seed_, dimension)).Uniform2D();
}

}  // namespace lacquer
