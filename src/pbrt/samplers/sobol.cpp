// Sampler "sobol": the Sobol sequence over the whole image; each pixel takes the points whose first two
// dimensions fall into it [Gruenschloss et al. 2012].
//
//   "integer pixelsamples"  16            samples per pixel, up to 2^24
//   "string randomization"  fastowen      or "permutedigits", "none", "owen"
//   "integer seed"          the option's  of the random numbers
#include <bit>

#include "pbrt/core/check.h"
#include "pbrt/samplers/block_sampler.h"
#include "pbrt/samplers/sampler_params.h"

namespace lacquer {

namespace {

/// Bits of a sample index in a pixel, and most bits of a pixel coordinate: together they make 64-bit indices.
constexpr int kSampleBits = 24, kMaxPixelBits = 20;

/// Linear algebra over GF(2) that leads from (pixel, sample) to indices and values. All fractions are
/// reversed.
///
/// An index has the bits (sample, middle, low) from above, the latter two of m bits, for an image of 2^m
/// pixels a side. Dimension 0 is the index itself, so `low` is the reversed x. Dimension 1 is
/// SobolSecond(index); its m lowest bits are to be the reversed y, which m equations determine `middle` for,
/// one solution for any sample and x.
class SobolTables {
  public:
    explicit SobolTables(Int2 resolution, int dimensions) : matrices_(MakeSobolMatrices(dimensions)) {
        while (bits_ < kMaxPixelBits && (1 << bits_) < std::max(resolution.x, resolution.y)) ++bits_;
        InvertMiddle();
        // Columns of the index, and of each dimension's values, for the bits of the sample.
        for (int t = 0; t < kSampleBits; ++t) {
            const uint64_t bit = uint64_t(1) << (2 * bits_ + t);
            indexColumns_.push_back(bit | Middle(SobolSecond(bit)) << bits_);
        }
        for (const SobolColumns& matrix : matrices_) {
            auto& columns = sampleColumns_.emplace_back();
            for (size_t t = 0; t < kSampleBits; ++t) columns[t] = Product(matrix, indexColumns_[t]);
        }
    }

    int PixelBits() const { return bits_; }
    /// Index of the pixel's sample 0.
    uint64_t FirstIndex(Int2 pixel) const {
        const uint64_t low = Reversed(uint32_t(pixel.x)), wanted = Reversed(uint32_t(pixel.y));
        return low | Middle(SobolSecond(low) ^ wanted) << bits_;
    }
    /// What the bits of a sample add to the index (by exclusive or).
    uint64_t IndexOf(uint32_t sample) const {
        uint64_t index = 0;
        for (size_t t = 0; sample != 0 && t < kSampleBits; ++t, sample >>= 1)
            if (sample & 1) index ^= indexColumns_[t];
        return index;
    }
    /// Value of an index in a dimension.
    uint32_t Value(int dimension, uint64_t index) const {
        return Product(matrices_[size_t(dimension)], index);
    }
    /// What the bits of a sample add to the values of a dimension.
    const std::array<uint32_t, kSampleBits>& SampleColumns(int dimension) const {
        return sampleColumns_[size_t(dimension)];
    }

  private:
    static uint32_t Product(const SobolColumns& matrix, uint64_t index) {
        uint32_t value = 0;
        for (size_t k = 0; index != 0; ++k, index >>= 1)
            if (index & 1) value ^= matrix[k];
        return value;
    }
    uint64_t Reversed(uint32_t coordinate) const {
        return bits_ == 0 ? 0 : ReverseBits(coordinate) >> (32 - bits_);
    }
    /// The middle bits whose contribution to the lowest bits of dimension 1 is that of `target`.
    uint64_t Middle(uint64_t target) const {
        uint64_t middle = 0;
        for (int k = 0; k < bits_; ++k)
            if ((target >> k) & 1) middle ^= inverse_[size_t(k)];
        return middle;
    }
    /// Gauss-Jordan elimination of the matrix from `middle` to the lowest bits of dimension 1.
    void InvertMiddle() {
        const auto m = size_t(bits_);
        std::vector<uint64_t> columns(m);
        inverse_.assign(m, 0);
        for (size_t k = 0; k < m; ++k) {
            columns[k] = SobolSecond(uint64_t(1) << (m + k));
            inverse_[k] = uint64_t(1) << k;
        }
        for (size_t k = 0; k < m; ++k) {
            size_t pivot = k;
            while (pivot < m && ((columns[pivot] >> k) & 1) == 0) ++pivot;
            LACQUER_CHECK(pivot < m);
            std::swap(columns[k], columns[pivot]);
            std::swap(inverse_[k], inverse_[pivot]);
            for (size_t other = 0; other < m; ++other) {
                if (other == k || ((columns[other] >> k) & 1) == 0) continue;
                columns[other] ^= columns[k];
                inverse_[other] ^= inverse_[k];
            }
        }
    }

    std::vector<SobolColumns> matrices_;
    int bits_ = 0;
    std::vector<uint64_t> inverse_, indexColumns_;
    std::vector<std::array<uint32_t, kSampleBits>> sampleColumns_;
};

class SobolSampler final : public BlockSampler {
  public:
    SobolSampler(int samplesPerPixel, Int2 resolution, Randomization randomization, int seed)
        : BlockSampler(seed),
          samplesPerPixel_(samplesPerPixel),
          randomization_(randomization),
          tables_(std::make_shared<const SobolTables>(resolution, kDimensions)) {
        for (int d = 0; d < kDimensions; ++d) seeds_[size_t(d)] = uint32_t(Hash(seed, d));
    }
    int SamplesPerPixel() const override { return samplesPerPixel_; }
    /// Powers of two only: dimensions far up are no nets together, and 12 samples have more error than 8.
    int NextGoodCount(int samples) const override { return int(std::bit_ceil(unsigned(samples) + 1)); }
    std::unique_ptr<Sampler> Clone() const override { return std::make_unique<SobolSampler>(*this); }

  protected:
    void StartPixel() override { pixelIndex_ = tables_->FirstIndex(Pixel()); }

    void Fill1D(int dimension, Lanes& x) override {
        std::array<uint32_t, kLanes> v = Values(dimension);
        Finish(dimension, v, x);
    }

    void Fill2D(int dimension, Lanes& x, Lanes& y) override {
        if (dimension == 0) return FillPixel(x, y);
        Fill1D(dimension, x);
        Fill1D(dimension + 1, y);
    }

  private:
    struct Prefix {
        uint64_t tag = 0;
        uint32_t value = 0;
    };

    void Finish(int dimension, std::array<uint32_t, kLanes>& v, Lanes& x) const {
        RandomizeReversed(randomization_, seeds_[size_t(dimension)], v);
        for (size_t l = 0; l < kLanes; ++l) x[l] = UnitFloat32(ReverseBits(v[l]));
    }

    /// Position in the pixel: the digits of the first two dimensions below those that name the pixel.
    void FillPixel(Lanes& x, Lanes& y) const {
        std::array<uint32_t, kLanes> v, w;
        for (uint32_t l = 0; l < kLanes; ++l) {
            const uint64_t index = pixelIndex_ ^ tables_->IndexOf(uint32_t(FirstIndex()) + l);
            v[l] = uint32_t(index >> tables_->PixelBits());
            w[l] = uint32_t(SobolSecond(index) >> tables_->PixelBits());
        }
        Finish(0, v, x);
        Finish(1, w, y);
    }

    /// Values of the block, reversed; all maps are linear over GF(2).
    std::array<uint32_t, kLanes> Values(int dimension) {
        Prefix& prefix = prefixes_[size_t(dimension)];
        if (prefix.tag != PixelTag()) prefix = {PixelTag(), tables_->Value(dimension, pixelIndex_)};
        const auto& columns = tables_->SampleColumns(dimension);
        uint32_t common = prefix.value;
        auto rest = uint32_t(FirstIndex()) / kLanes;
        for (size_t t = 3; rest != 0 && t < kSampleBits; ++t, rest >>= 1)
            if (rest & 1) common ^= columns[t];
        std::array<uint32_t, kLanes> v;
        for (uint32_t l = 0; l < kLanes; ++l)
            v[l] = common ^ (l & 1 ? columns[0] : 0) ^ (l & 2 ? columns[1] : 0) ^ (l & 4 ? columns[2] : 0);
        return v;
    }

    int samplesPerPixel_;
    Randomization randomization_;
    std::shared_ptr<const SobolTables>
        tables_;  ///< immutable; clones share it and may outlive the first sampler
    uint64_t pixelIndex_ = 0;
    std::array<uint32_t, kDimensions> seeds_{};
    std::array<Prefix, kDimensions> prefixes_{};
};

std::unique_ptr<Sampler> CreateSobol(const SamplerArgs& args) {
    const int samplesPerPixel = ReadPixelSamples(args, 16);
    const Randomization randomization = ReadRandomization(args, BinaryRandomizations());
    return std::make_unique<SobolSampler>(samplesPerPixel, args.resolution, randomization, ReadSeed(args));
}

}  // namespace

LACQUER_REGISTER(SamplerKind, "sobol", CreateSobol);

}  // namespace lacquer
