// The first two dimensions of the Sobol sequence for every pair of dimensions, each pixel and pair with an
// order and a scramble of its own [Burley 2020].
#pragma once

#include "pbrt/samplers/block_sampler.h"
#include "pbrt/samplers/low_discrepancy.h"

namespace lacquer {

/// Samplers "paddedsobol" and "pmj02bn". With any randomisation, the first 2^k samples of a pixel have one
/// point in each elementary interval of a pair of dimensions.
class PaddedSobolSampler final : public BlockSampler {
  public:
    PaddedSobolSampler(int samplesPerPixel, Randomization randomization, int seed)
        : BlockSampler(seed), samplesPerPixel_(samplesPerPixel), randomization_(randomization) {}
    int SamplesPerPixel() const override { return samplesPerPixel_; }
    int NextGoodCount(int samples) const override { return NextCountOfNets(samples); }
    std::unique_ptr<Sampler> Clone() const override { return std::make_unique<PaddedSobolSampler>(*this); }

  protected:
    void StartPixel() override { pixelHash_ = Hash(Pixel().x, Pixel().y, Seed()); }

    void Fill1D(int dimension, Lanes& x) override {
        const uint64_t key = MixBits(pixelHash_ ^ uint64_t(2 * dimension + 1));
        std::array<uint32_t, kLanes> v = ShuffledIndices(key);
        RandomizeReversed(randomization_, uint32_t(MixBits(key) >> 32), v);
        for (size_t l = 0; l < kLanes; ++l) x[l] = UnitFloat32(ReverseBits(v[l]));
    }

    void Fill2D(int dimension, Lanes& x, Lanes& y) override {
        const uint64_t key = MixBits(pixelHash_ ^ uint64_t(2 * dimension)), scramble = MixBits(key);
        std::array<uint32_t, kLanes> v = ShuffledIndices(key), w;
        for (size_t l = 0; l < kLanes; ++l) w[l] = SobolSecond(v[l]);
        RandomizeReversed(randomization_, uint32_t(scramble >> 32), v);
        RandomizeReversed(randomization_, uint32_t(scramble), w);
        for (size_t l = 0; l < kLanes; ++l) {
            x[l] = UnitFloat32(ReverseBits(v[l]));
            y[l] = UnitFloat32(ReverseBits(w[l]));
        }
    }

  private:
    /// The block's indices under a nested shuffle: the first 2^k samples become an aligned block of the
    /// sequence for every k.
    std::array<uint32_t, kLanes> ShuffledIndices(uint64_t key) const {
        std::array<uint32_t, kLanes> indices;
        const auto first = uint32_t(FirstIndex()), seed = uint32_t(key);
        for (uint32_t l = 0; l < kLanes; ++l)
            indices[l] = ReverseBits(FastOwenReversed(ReverseBits(first + l), seed));
        return indices;
    }

    int samplesPerPixel_;
    Randomization randomization_;
    uint64_t pixelHash_ = 0;
};

}  // namespace lacquer
