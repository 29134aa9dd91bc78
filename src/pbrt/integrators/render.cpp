#include "pbrt/integrators/render.h"

#include <atomic>
#include <chrono>

#include "pbrt/core/parallel.h"

namespace lacquer {

namespace {

constexpr int kTileSize = 16;
constexpr int kFirstPass = 8, kLongestPass = 64;

using Clock = std::chrono::steady_clock;
double SecondsSince(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// What one thread needs to render; on its own cache lines.
struct alignas(128) Worker {
    Worker(const Sampler& prototype, bool wantAlbedo) : sampler(prototype.Clone()), recorder(wantAlbedo) {}
    std::unique_ptr<Sampler> sampler;
    ThreadState state;
    FirstHitRecorder recorder;
};

class RenderLoop {
  public:
    RenderLoop(const Scene& scene, const Integrator& integrator, const Sampler& sampler, Film& film,
               const RenderOptions& options, Observer& observer)
        : scene_(scene), integrator_(integrator), film_(film), options_(options), observer_(observer) {
        const bool wantAlbedo = options.aovs && options.aovs->Wants("albedo");
        for (int i = 0; i < MaxThreads(); ++i)
            workers_.push_back(std::make_unique<Worker>(sampler, wantAlbedo));
        if (options.aovs && options.aovs->WantsFirstHit())
            for (auto& worker : workers_) worker->state.firstHit = &worker->recorder;
    }

    RenderStats Run() {
        const Clock::time_point start = Clock::now();
        const int count = options_.endSample - options_.firstSample;
        observer_.Begin("Rendering", int64_t(count) * film_.PixelBounds().Area());
        RenderStats stats;
        int done = 0;
        while (done < count && !observer_.ShouldStop()) {
            const int pass = PassLength(done, count, SecondsSince(start));
            if (pass == 0) {
                stats.timedOut = true;
                break;
            }
            if (!RenderPass(options_.firstSample + done, options_.firstSample + done + pass)) break;
            done += pass;
            if (options_.afterPass) options_.afterPass(done);
        }
        observer_.End();
        stats.interrupted = done < count && !stats.timedOut;
        stats.samplesPerPixel = done;
        stats.threads = int(workers_.size());
        for (const auto& worker : workers_) {
            stats.cameraRays += worker->state.cameraRays;
            stats.raysTraced += worker->state.raysTraced;
            stats.shadowRays += worker->state.shadowRays;
            stats.badSamples += worker->state.badSamples;
            stats.pathLengthSum += worker->state.pathLengthSum;
            stats.bxdf += worker->state.bxdf;
        }
        stats.seconds = SecondsSince(start);
        return stats;
    }

  private:
    /// Samples of the next pass; 0 if the time limit leaves no room for one more. The first pass always runs.
    int PassLength(int done, int count, double seconds) const {
        const int first = std::isfinite(options_.timeLimit) ? 1 : kFirstPass;  // a limit wants to be met
        const int goal = done == 0 ? first : std::min(4 * done, done + kLongestPass);
        int pass = std::min(goal, count) - done;
        if (std::isfinite(options_.timeLimit) && done > 0) {
            const double perSample = seconds / done;
            // In double: the room for samples can be more than an int holds.
            pass = int(std::min(double(pass), std::max(0.0, (options_.timeLimit - seconds) / perSample)));
        }
        return pass;
    }

    /// False if the observer stopped it half-way.
    bool RenderPass(int first, int end) {
        std::atomic<bool> stopped = false;
        ParallelTiles(film_.PixelBounds(), kTileSize, [&](const Bounds2i& tile) {
            if (stopped || observer_.ShouldStop()) {
                stopped = true;
                return;
            }
            Worker& worker = *workers_[size_t(ThreadIndex())];
            for (int y = tile.min.y; y < tile.max.y; ++y)
                for (int x = tile.min.x; x < tile.max.x; ++x)
                    for (int sample = first; sample < end; ++sample) RenderSample({x, y}, sample, worker);
            observer_.Advance(tile.Area() * (end - first));
        });
        return !stopped;
    }

    void RenderSample(Int2 pixel, int index, Worker& worker) {
        Sampler& sampler = *worker.sampler;
        ThreadState& state = worker.state;
        sampler.StartPixelSample(pixel, index);
        state.rng = Rng(Hash(options_.seed, pixel.x, pixel.y, index));

        // Film position by the filter, then wavelengths, time and lens.
        const Point2 uFilter = sampler.GetPixel2D();
        const float uLambda = sampler.Get1D();
        CameraSample cameraSample;
        cameraSample.time = sampler.Get1D();
        cameraSample.pLens = sampler.Get2D();
        FilterSample filter = film_.Filter().Sample(uFilter);
        if (!options_.pixelJitter) {
            filter = {Point2(0), 1};
            cameraSample.time = 0.5f;
            cameraSample.pLens = Point2(0.5f);
        }
        cameraSample.pFilm = Point2(pixel) + filter.offset + Point2(0.5f);
        SampledWavelengths lambda = film_.SampleWavelengths(options_.wavelengthJitter ? uLambda : 0.5f);

        const std::optional<CameraRay> ray = scene_.Camera().GenerateRay(cameraSample);
        SampledSpectrum L(0);
        worker.recorder.Clear();
        if (ray) {
            ++state.cameraRays;
            L = integrator_.Li(*ray, lambda, sampler, state) * ray->weight;
        }
        if (!film_.AddSample(pixel, L, lambda, filter.weight)) ++state.badSamples;
        if (options_.aovs) options_.aovs->Add(pixel, worker.recorder.Last(), L, lambda);
        state.arena.Reset();
    }

    const Scene& scene_;
    const Integrator& integrator_;
    Film& film_;
    const RenderOptions& options_;
    Observer& observer_;
    std::vector<std::unique_ptr<Worker>> workers_;
};

}  // namespace

RenderStats Render(const Scene& scene, const Integrator& integrator, const Sampler& sampler, Film& film,
                   const RenderOptions& options, Observer& observer) {
    return RenderLoop(scene, integrator, sampler, film, options, observer).Run();
}

}  // namespace lacquer
