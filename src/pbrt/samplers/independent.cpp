// Sampler "independent": independent uniform numbers, without stratification; the baseline of all other
// samplers.
//
//   "integer pixelsamples"  4             samples per pixel, up to 2^24
//   "integer seed"          the option's  of the random numbers
#include "pbrt/base/sampler.h"
#include "pbrt/core/rng.h"
#include "pbrt/samplers/sampler_params.h"

namespace lacquer {

namespace {

class IndependentSampler final : public Sampler {
  public:
    IndependentSampler(int samplesPerPixel, int seed) : samplesPerPixel_(samplesPerPixel), seed_(seed) {}
    int SamplesPerPixel() const override { return samplesPerPixel_; }
    void StartPixelSample(Int2 pixel, int index) override {
        rng_ = Rng(Hash(pixel.x, pixel.y, index, seed_));
    }
    float Get1D() override { return rng_.Uniform(); }
    Point2 Get2D() override { return rng_.Uniform2D(); }
    std::unique_ptr<Sampler> Clone() const override { return std::make_unique<IndependentSampler>(*this); }

  private:
    int samplesPerPixel_, seed_;
    Rng rng_;
};

std::unique_ptr<Sampler> CreateIndependent(const SamplerArgs& args) {
    const int samplesPerPixel = ReadPixelSamples(args, 4);
    return std::make_unique<IndependentSampler>(samplesPerPixel, ReadSeed(args));
}

}  // namespace

LACQUER_REGISTER(SamplerKind, "independent", CreateIndependent);

}  // namespace lacquer
