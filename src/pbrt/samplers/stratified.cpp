// Sampler "stratified": each pixel has a grid of strata, visited in an order of its own in every dimension.
//
//   "integer xsamples", "integer ysamples"  4, 4          strata along each axis; their product is the
//                                                         samples per pixel
//   "bool jitter"                           true          false: samples at the centres of the strata
//   "integer seed"                          the option's  of the random numbers
#include "pbrt/samplers/block_sampler.h"
#include "pbrt/samplers/sampler_params.h"

namespace lacquer {

namespace {

class StratifiedSampler final : public BlockSampler {
  public:
    StratifiedSampler(int nx, int ny, bool jitter, int seed)
        : BlockSampler(seed), nx_(nx), ny_(ny), jitter_(jitter) {}
    int SamplesPerPixel() const override { return nx_ * ny_; }
    std::unique_ptr<Sampler> Clone() const override { return std::make_unique<StratifiedSampler>(*this); }

  protected:
    void StartPixel() override { pixelHash_ = Hash(Pixel().x, Pixel().y, Seed()); }

    void Fill1D(int dimension, Lanes& x) override {
        const uint64_t key = MixBits(pixelHash_ ^ uint64_t(2 * dimension + 1));
        for (int lane = 0; lane < kLanes; ++lane) {
            const Point2 jitter = Jitter(key, lane);
            const float position = (float(Stratum(key, lane)) + jitter.x) / float(nx_ * ny_);
            x[size_t(lane)] = std::min(position, OneMinusEpsilon);
        }
    }

    void Fill2D(int dimension, Lanes& x, Lanes& y) override {
        const uint64_t key = MixBits(pixelHash_ ^ uint64_t(2 * dimension));
        for (int lane = 0; lane < kLanes; ++lane) {
            const Point2 jitter = Jitter(key, lane);
            const int stratum = Stratum(key, lane), row = stratum / nx_, column = stratum - row * nx_;
            x[size_t(lane)] = std::min((float(column) + jitter.x) / float(nx_), OneMinusEpsilon);
            y[size_t(lane)] = std::min((float(row) + jitter.y) / float(ny_), OneMinusEpsilon);
        }
    }

  private:
    /// Cell of a sample: the cells in random order.
    int Stratum(uint64_t key, int lane) const {
        const auto count = uint32_t(nx_ * ny_), index = uint32_t(FirstIndex() + lane);
        return int(PermutationElement(index < count ? index : index % count, count, uint32_t(key >> 32)));
    }
    Point2 Jitter(uint64_t key, int lane) const {
        if (!jitter_) return Point2(0.5f);
        return Rng(key + uint64_t(FirstIndex() + lane)).Uniform2D();
    }

    int nx_, ny_;
    bool jitter_;
    uint64_t pixelHash_ = 0;
};

std::unique_ptr<Sampler> CreateStratified(const SamplerArgs& args) {
    const bool jitter = args.params.GetBool("jitter", true);
    int nx = args.params.GetIntInRange("xsamples", 4, 1, kMaxSamplesPerPixel);
    int ny = args.params.GetIntInRange("ysamples", 4, 1, kMaxSamplesPerPixel);
    if (int64_t(nx) * ny > kMaxSamplesPerPixel)
        args.params.Fail("xsamples",
                         "xsamples times ysamples is more than " + std::to_string(kMaxSamplesPerPixel));

    // An overriding count is split into the two factors that are nearest to each other.
    if (const std::optional<int> count = CheckedOverride(args)) {
        ny = int(std::sqrt(float(*count)));
        while (*count % ny != 0) --ny;
        nx = *count / ny;
    }
    return std::make_unique<StratifiedSampler>(nx, ny, jitter, ReadSeed(args));
}

}  // namespace

LACQUER_REGISTER(SamplerKind, "stratified", CreateStratified);

}  // namespace lacquer
