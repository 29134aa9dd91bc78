#include "pbrt/integrators/pilot_samples.h"

#include <array>
#include <atomic>
#include <bit>
#include <memory>

#include "pbrt/core/parallel.h"
#include "pbrt/film/estimate_xyz.h"
#include "pbrt/samplers/padded_sobol.h"

namespace lacquer {
namespace {

constexpr int kPilotTile = 16;
/// Part of a render's samples that is spent on pilots, and the most of them in each half.
constexpr int kPilotPart = 32, kMaxInHalf = 16;
/// Of one sample: squares of it can be summed.
constexpr float kMaxValue = 1e15f;
/// Tells the random numbers of pilots from those of the render.
constexpr int kPilotStream = 3;

/// What one thread needs; on its own cache lines.
struct alignas(128) PilotWorker {
    PilotWorker(int samples, int seed)
        : halves{{{samples, Randomization::FastOwen, HalfSeed(seed, 0)},
                  {samples, Randomization::FastOwen, HalfSeed(seed, 1)}}} {}
    static int HalfSeed(int seed, int half) { return int(Hash(seed, kPilotStream, half) >> 33); }
    std::array<PaddedSobolSampler, 2> halves;
    ThreadState state;
};

class PilotLoop {
  public:
    PilotLoop(const Scene& scene, const Integrator& integrator, const Film& film, const PilotOptions& options)
        : scene_(scene),
          integrator_(integrator),
          film_(film),
          options_(options),
          samples_(PilotSamples(options.samples) / 2) {
        for (int i = 0; i < MaxThreads(); ++i)
            workers_.push_back(std::make_unique<PilotWorker>(samples_, options.seed));
    }

    /// Empty if it was stopped.
    std::vector<PilotPixel> Run(Observer& observer) {
        const Bounds2i bounds = film_.PixelBounds();
        std::vector<PilotPixel> pilots(size_t(bounds.Area()));
        observer.Begin("Pilot samples", int64_t(bounds.Area()) * 2 * samples_, "samples");
        std::atomic<bool> stopped = false;
        ParallelTiles(bounds, kPilotTile, TileOrder::Rows, [&](const Bounds2i& tile) {
            PilotWorker& worker = *workers_[size_t(ThreadIndex())];
            for (int y = tile.min.y; y < tile.max.y; ++y)
                for (int x = tile.min.x; x < tile.max.x; ++x) {
                    if (stopped || observer.ShouldStop() || scene_.TexturesFailed()) {
                        stopped = true;
                        return;
                    }
                    pilots[size_t(y - bounds.min.y) * size_t(bounds.Width()) + size_t(x - bounds.min.x)] =
                        PixelOf({x, y}, worker);
                }
            observer.Advance(int64_t(tile.Area()) * 2 * samples_);
        });
        observer.End();
        scene_.CheckTextures();
        if (stopped) pilots.clear();
        return pilots;
    }

  private:
    PilotPixel PixelOf(Int2 pixel, PilotWorker& worker) const {
        const int64_t before = RaysOf(worker.state);
        const RGB a = Estimate(pixel, 0, worker), b = Estimate(pixel, 1, worker);
        const double rays = double(RaysOf(worker.state) - before) / (2 * samples_);
        return {(a + b) * 0.5f, a - b, float(rays)};
    }

    static int64_t RaysOf(const ThreadState& state) { return state.rays.nearest + state.rays.shadow; }

    RGB Estimate(Int2 pixel, int half, PilotWorker& worker) const {
        Sampler& sampler = worker.halves[size_t(half)];
        XYZ sum(0);
        for (int i = 0; i < samples_; ++i) sum += Sample(pixel, i, half, sampler, worker.state);
        return film_.ColorSpace().ToRGB(sum / float(samples_));
    }

    XYZ Sample(Int2 pixel, int index, int half, Sampler& sampler, ThreadState& state) const {
        sampler.StartPixelSample(pixel, index);
        state.rng = Rng(Hash(options_.seed, pixel.x, pixel.y, index, kPilotStream + half));
        state.dimensions = BxDFDimensions(sampler);
        FilmSample sample = SampleFilm(film_, pixel, options_.jitter, sampler);
        SampledSpectrum L(0);
        if (const std::optional<CameraRay> ray = scene_.Camera().GenerateRay(sample.camera))
            L = integrator_.Li(*ray, sample.lambda, sampler, state) * ray->weight;
        state.arena.Reset();
        const XYZ xyz = L.IsValid() ? EstimateXYZ(L, sample.lambda) * sample.weight : XYZ(0);
        return IsFinite(xyz) ? glm::clamp(xyz, -kMaxValue, kMaxValue) : XYZ(0);
    }

    const Scene& scene_;
    const Integrator& integrator_;
    const Film& film_;
    const PilotOptions& options_;
    const int samples_;  ///< of each half
    std::vector<std::unique_ptr<PilotWorker>> workers_;
};

}  // namespace

int PilotSamples(int samples) {
    const auto half = std::bit_floor(unsigned(std::max(samples / (2 * kPilotPart), 1)));
    return 2 * std::min(int(half), kMaxInHalf);
}

SampleShares MeasureShares(const Scene& scene, const Integrator& integrator, const Film& film,
                           const PilotOptions& options, Observer& observer) {
    const std::vector<PilotPixel> pilots = PilotLoop(scene, integrator, film, options).Run(observer);
    const Bounds2i pixels = film.PixelBounds();
    if (pilots.empty()) return {pixels, std::vector<uint8_t>(size_t(pixels.Area()), SampleShares::kUnit)};
    return SharesByPilots(pixels, pilots);
}

}  // namespace lacquer
