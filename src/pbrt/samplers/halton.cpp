// Sampler "halton": the Halton sequence over tiles of the image; each pixel takes the points whose first two
// dimensions fall into it.
//
//   "integer pixelsamples"  16             samples per pixel, up to 2^24
//   "string randomization"  permutedigits  or "none", "owen"
//   "integer seed"          the option's   of the random numbers
#include "pbrt/samplers/block_sampler.h"
#include "pbrt/samplers/sampler_params.h"

namespace lacquer {

namespace {

/// Digits of `value` in `base`, mirrored among the first `digits`.
int64_t MirrorDigits(int value, int base, int digits) {
    int64_t mirrored = 0;
    for (int i = 0; i < digits; ++i, value /= base) mirrored = mirrored * base + value % base;
    return mirrored;
}

/// The x in [0, m) with a x = 1 modulo m, for coprime a and m.
int64_t InverseModulo(int64_t a, int64_t m) {
    for (int64_t x = 0; x < m; ++x)
        if (a * x % m == 1 % m) return x;
    return 0;
}

/// What depends on nothing but the seed and the resolution, shared by clones.
struct HaltonTables {
    std::vector<RadicalInverse> inverses;     ///< by dimension
    std::vector<RadicalInverse::Step> steps;  ///< from one sample of a pixel to the next
};

class HaltonSampler final : public BlockSampler {
  public:
    HaltonSampler(int samplesPerPixel, Int2 resolution, Randomization randomization, int seed)
        : BlockSampler(seed),
          samplesPerPixel_(samplesPerPixel),
          isOwen_(randomization == Randomization::Owen),
          primes_(FirstPrimes(kDimensions)) {
        // A tile has 2^j x 3^k pixels and covers the image, or at least 128 of its pixels in each direction.
        while (width_ < std::min(resolution.x, kMaxTile)) width_ *= 2, ++digitsX_;
        while (height_ < std::min(resolution.y, kMaxTile)) height_ *= 3, ++digitsY_;
        stepX_ = height_ * InverseModulo(height_, width_);
        stepY_ = width_ * InverseModulo(width_, height_);
        tilesAcross_ = (std::max<int64_t>(resolution.x, 1) + width_ - 1) / width_;

        auto tables = std::make_shared<HaltonTables>();
        for (int d = 0; d < kDimensions; ++d) {
            tables->inverses.emplace_back(primes_[size_t(d)], randomization == Randomization::PermuteDigits,
                                          Hash(seed));
            tables->steps.push_back(tables->inverses.back().StepOf(uint64_t(Stride() / ScaleOf(d))));
        }
        tables_ = std::move(tables);
    }
    int SamplesPerPixel() const override { return samplesPerPixel_; }
    std::unique_ptr<Sampler> Clone() const override { return std::make_unique<HaltonSampler>(*this); }

  protected:
    void StartPixel() override {
        // The residues modulo 2^j and 3^k place a point in a column and a row; both together give the index.
        const int64_t x = Pixel().x, y = Pixel().y;
        const int64_t column = FloorMod(x, width_), row = FloorMod(y, height_);
        const int64_t residue =
            MirrorDigits(int(column), 2, digitsX_) * stepX_ + MirrorDigits(int(row), 3, digitsY_) * stepY_;
        // Each tile has a part of the sequence of its own.
        const int64_t tile = FloorMod((y - row) / height_ * tilesAcross_ + (x - column) / width_, kMaxTiles);
        pixelIndex_ = uint64_t(residue % Stride() + tile * kSamplesPerTile * Stride());
    }

    void Fill1D(int dimension, Lanes& x) override {
        // The step divides without remainder, so that what is left of the indices is a progression, too.
        const uint64_t first = FirstOfBlock() / uint64_t(ScaleOf(dimension));
        if (isOwen_) {
            const uint64_t step = uint64_t(Stride() / ScaleOf(dimension));
            for (uint64_t l = 0; l < kLanes; ++l)
                x[l] =
                    OwenRadicalInverse(primes_[size_t(dimension)], first + l * step, Hash(Seed(), dimension));
        } else {
            tables_->inverses[size_t(dimension)].OfProgression(first, tables_->steps[size_t(dimension)], x);
        }
    }

    void Fill2D(int dimension, Lanes& x, Lanes& y) override {
        Fill1D(dimension, x);
        Fill1D(dimension + 1, y);
    }

  private:
    static constexpr int kMaxTile = 128;
    /// 2^15 pixels a tile, 2^16 samples and 2^18 tiles keep indices below 2^50; what is beyond repeats other
    /// tiles' points.
    static constexpr int64_t kSamplesPerTile = int64_t(1) << 16, kMaxTiles = int64_t(1) << 18;

    static int64_t FloorMod(int64_t a, int64_t b) { return ((a % b) + b) % b; }
    int64_t Stride() const { return width_ * height_; }
    uint64_t FirstOfBlock() const { return pixelIndex_ + uint64_t(FirstIndex()) * uint64_t(Stride()); }
    /// The position in the pixel is in the digits above those that name the pixel.
    int64_t ScaleOf(int dimension) const {
        if (dimension == 0) return width_;
        return dimension == 1 ? height_ : 1;
    }

    int samplesPerPixel_;
    bool isOwen_;
    std::vector<int> primes_;
    std::shared_ptr<const HaltonTables> tables_;  ///< immutable; clones may outlive the first sampler
    int64_t width_ = 1, height_ = 1;              ///< of a tile [pixels]
    int digitsX_ = 0, digitsY_ = 0;               ///< in bases 2 and 3
    int64_t stepX_ = 0, stepY_ = 0, tilesAcross_ = 1;
    uint64_t pixelIndex_ = 0;
};

std::unique_ptr<Sampler> CreateHalton(const SamplerArgs& args) {
    const int samplesPerPixel = ReadPixelSamples(args, 16);
    const Randomization randomization = ReadRandomization(args, {"permutedigits", "none", "owen"});
    return std::make_unique<HaltonSampler>(samplesPerPixel, args.resolution, randomization, ReadSeed(args));
}

}  // namespace

LACQUER_REGISTER(SamplerKind, "halton", CreateHalton);

}  // namespace lacquer
