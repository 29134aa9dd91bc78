// What the stratified samplers share: values are made for eight samples of a pixel at a time.
#pragma once

#include <array>
#include <cstdint>

#include "pbrt/base/sampler.h"
#include "pbrt/core/rng.h"

namespace lacquer {

/// A sampler that computes a dimension for eight consecutive sample indices of a pixel at once, when the
/// first of them asks for it: vector instructions apply, and what depends on the pixel only is done once. A
/// value is a pure function of (seed, pixel, index, dimension) and of whether one or two dimensions are asked
/// for; the block is only a cache. Dimensions 0 and 1 are the position in the pixel. From kDimensions on,
/// values are independent.
class BlockSampler : public Sampler {
  public:
    BlockSampler& operator=(const BlockSampler&) = delete;

    void StartPixelSample(Int2 pixel, int index) final {
        const int first = index & ~(kLanes - 1);
        if (pixel != pixel_ || first != firstIndex_) StartBlock(pixel, first);
        lane_ = size_t(index - first);
        dimension_ = 2;
    }
    float Get1D() final {
        const int dimension = dimension_++;
        if (dimension >= kDimensions) return Independent(dimension).x;
        Entry& entry = entries_[size_t(dimension)];
        if (entry.tag != blockTag_) Refill1D(dimension, entry);
        return entry.x[lane_];
    }
    Point2 Get2D() final {
        const int dimension = dimension_;
        dimension_ += 2;
        if (dimension >= kDimensions - 1) return Independent(dimension);
        return Cached2D(dimension);
    }
    void Skip1D() final { ++dimension_; }
    void Skip2D() final { dimension_ += 2; }
    Point2 GetPixel2D() final { return Cached2D(0); }
    /// The first eight dimensions of the Sobol sequence, in an order and with scrambles [Owen 1995] of the
    /// pixel and the set, whatever the sampler's own points are. Some 15 ns.
    bool GetPoint(const PointSet& set, LeadingNumbers::Block* x) const final;

  protected:
    static constexpr int kLanes = 8;
    static constexpr int kDimensions = 128;
    using Lanes = std::array<float, kLanes>;

    explicit BlockSampler(int seed) : seed_(seed) {}
    BlockSampler(const BlockSampler&) = default;

    /// What depends on the pixel only; Pixel() is the new one.
    virtual void StartPixel() {}
    /// Values of `dimension` for the indices FirstIndex() + 0..7.
    virtual void Fill1D(int dimension, Lanes& x) = 0;
    /// Values of `dimension` (below kDimensions - 1) and the next one; dimension 0 is the position in the
    /// pixel.
    virtual void Fill2D(int dimension, Lanes& x, Lanes& y) = 0;

    int Seed() const { return seed_; }
    Int2 Pixel() const { return pixel_; }
    int FirstIndex() const { return firstIndex_; }
    /// Changes with every new pixel; never 0.
    uint64_t PixelTag() const { return pixelTag_; }

  private:
    struct Entry {
        uint64_t tag = 0;  ///< of the block and kind that the values are for
        alignas(32) Lanes x{};
        alignas(32) Lanes y{};
    };

    Point2 Cached2D(int dimension) {
        Entry& entry = entries_[size_t(dimension)];
        if (entry.tag != blockTag_ + 1) Refill2D(dimension, entry);
        return {entry.x[lane_], entry.y[lane_]};
    }
    void StartBlock(Int2 pixel, int first);
    void Refill1D(int dimension, Entry& entry);
    void Refill2D(int dimension, Entry& entry);
    Point2 Independent(int dimension) const;

    int seed_ = 0;
    Int2 pixel_{0};
    int firstIndex_ = -1;  ///< none yet
    int dimension_ = 2;
    size_t lane_ = 0;
    uint64_t blockTag_ = 0;  ///< even; tag + 1 marks entries with two dimensions
    uint64_t pixelTag_ = 0;
    uint64_t pointsHash_ = 0;  ///< of the pixel
    std::array<Entry, kDimensions> entries_{};
};

}  // namespace lacquer
