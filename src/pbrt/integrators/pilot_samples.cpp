#include "pbrt/integrators/pilot_samples.h"

#include <array>
#include <atomic>
#include <bit>
#include <memory>

#include "pbrt/core/parallel.h"
#include "pbrt/samplers/padded_sobol.h"

namespace lacquer {
namespace {

constexpr int kPilotTile = 16;
/// Part of the samples of an image that pilots are, the most in one estimate, and of pixels with pilots.
constexpr int kPilotPart = 32, kMaxInHalf = 16, kMaxPilotPixels = 2500000;
/// Random numbers, of walks within stacks and media above all, that take the time of a ray: by regression of
/// the times of 90 parts of ten scenes, which this cost tells to 26 %, and rays alone to 49 %.
constexpr int kNumbersOfRay = 7;
/// Tells the random numbers of pilots from those of the render.
constexpr int kPilotStream = 3;

/// What one thread needs; on its own cache lines.
struct alignas(128) PilotWorker {
    PilotWorker(int samples, int seed)
        : halves{{{samples, Randomization::FastOwen, HalfSeed(seed, 0)},
                  {samples, Randomization::FastOwen, HalfSeed(seed, 1)}}} {}
    static int HalfSeed(int seed, int half) { return int(Hash(seed, kPilotStream, half) >> 33); }
    /// Of all samples so far, in random numbers: clocks would tell it better, and otherwise each time.
    int64_t Cost() const {
        return (state.rays.nearest + state.rays.shadow) * kNumbersOfRay + state.bxdf.numbers + numbers;
    }
    std::array<PaddedSobolSampler, 2> halves;
    ThreadState state;
    int64_t numbers = 0;  ///< random ones that paths took
};

class PilotLoop {
  public:
    PilotLoop(const Scene& scene, const Integrator& integrator, const Film& film, const PilotOptions& options)
        : scene_(scene),
          integrator_(integrator),
          film_(film),
          cameraNumbers_(scene),
          options_(options),
          plan_(PilotPlanOf(options.samples, film.PixelBounds().Area())) {
        for (int i = 0; i < MaxThreads(); ++i)
            workers_.push_back(std::make_unique<PilotWorker>(plan_.half, options.seed));
    }

    /// Of each block, rows from the top. Empty if it was stopped.
    std::vector<PilotPixel> Run(Observer& observer) {
        const Int2 blocks = PilotBlocksOf(film_.PixelBounds(), plan_.spacing);
        std::vector<PilotPixel> pilots(size_t(blocks.x) * size_t(blocks.y));
        observer.Begin("Pilot samples", int64_t(pilots.size()) * 2 * plan_.half, "samples");
        std::atomic<bool> stopped = false;
        ParallelTiles({Int2(0), blocks}, kPilotTile, TileOrder::Rows, [&](const Bounds2i& tile) {
            PilotWorker& worker = *workers_[size_t(ThreadIndex())];
            for (int y = tile.min.y; y < tile.max.y; ++y)
                for (int x = tile.min.x; x < tile.max.x; ++x) {
                    if (stopped || observer.ShouldStop() || scene_.TexturesFailed()) {
                        stopped = true;
                        return;
                    }
                    pilots[size_t(y) * size_t(blocks.x) + size_t(x)] = PixelOf(PlaceIn({x, y}), worker);
                }
            observer.Advance(int64_t(tile.Area()) * 2 * plan_.half);
        });
        observer.End();
        scene_.CheckTextures();
        if (stopped) pilots.clear();
        return pilots;
    }

  private:
    /// The pixel of a block that has pilots: any, so that no pattern of the image hides from them.
    Int2 PlaceIn(Int2 block) const {
        const Bounds2i bounds = film_.PixelBounds();
        Rng rng(Hash(options_.seed, block.x, block.y, kPilotStream, 0));
        const auto side = uint32_t(plan_.spacing);
        const Int2 within(int(rng.UniformInt(side)), int(rng.UniformInt(side)));
        return glm::min(bounds.min + plan_.spacing * block + within, bounds.max - 1);
    }

    PilotPixel PixelOf(Int2 pixel, PilotWorker& worker) const {
        const int64_t before = worker.Cost();
        const RGB a = Estimate(pixel, 0, worker), b = Estimate(pixel, 1, worker);
        const double cost = double(worker.Cost() - before) / (kNumbersOfRay * 2 * plan_.half);
        return {(a + b) * 0.5f, a - b, float(cost)};
    }

    RGB Estimate(Int2 pixel, int half, PilotWorker& worker) const {
        XYZ sum(0);
        for (int i = 0; i < plan_.half; ++i) sum += Sample(pixel, i, half, worker);
        return film_.ColorSpace().ToRGB(sum / float(plan_.half));
    }

    XYZ Sample(Int2 pixel, int index, int half, PilotWorker& worker) const {
        Sampler& sampler = worker.halves[size_t(half)];
        ThreadState& state = worker.state;
        sampler.StartPixelSample(pixel, index);
        const Rng start(Hash(options_.seed, pixel.x, pixel.y, index, kPilotStream + half));
        state.rng = start;
        state.dimensions = BxDFDimensions(sampler);
        FilmSample sample = SampleFilm(film_, pixel, options_.jitter, cameraNumbers_, sampler);
        SampledSpectrum L(0);
        if (const std::optional<CameraRay> ray = scene_.Camera().GenerateRay(sample.camera))
            L = integrator_.Li(*ray, sample.lambda, sampler, state) * ray->weight;
        state.arena.Reset();
        worker.numbers += int64_t(state.rng.CountSince(start));
        return XYZOf(sample, L, film_);
    }

    const Scene& scene_;
    const Integrator& integrator_;
    const Film& film_;
    const CameraNumbers cameraNumbers_;
    const PilotOptions& options_;
    const PilotPlan plan_;
    std::vector<std::unique_ptr<PilotWorker>> workers_;
};

}  // namespace

PilotPlan PilotPlanOf(int samples, int64_t pixels) {
    constexpr int kMaxSpacing = 8;
    const auto inHalf = [&](int spacing) { return int64_t(samples) * spacing * spacing / (2 * kPilotPart); };
    PilotPlan plan;
    while (plan.spacing < kMaxSpacing &&
           (inHalf(plan.spacing) < 1 || pixels / Sqr(plan.spacing) > kMaxPilotPixels))
        plan.spacing *= 2;
    plan.half = std::clamp(int(std::bit_floor(uint64_t(std::min(inHalf(plan.spacing), int64_t(kMaxInHalf))))),
                           1, kMaxInHalf);
    return plan;
}

SampleShares MeasureShares(const Scene& scene, const Integrator& integrator, const Film& film,
                           const PilotOptions& options, Observer& observer) {
    const std::vector<PilotPixel> pilots = PilotLoop(scene, integrator, film, options).Run(observer);
    const Bounds2i pixels = film.PixelBounds();
    if (pilots.empty()) return {pixels, std::vector<uint8_t>(size_t(pixels.Area()), SampleShares::kUnit)};
    return SharesByPilots(pixels, PilotPlanOf(options.samples, pixels.Area()).spacing, pilots);
}

}  // namespace lacquer
