#include "pbrt/integrators/render.h"

#include <atomic>

#include "pbrt/core/clock.h"
#include "pbrt/core/parallel.h"
#include "pbrt/film/pass_recorder.h"
#include "pbrt/integrators/footprint.h"
#include "pbrt/integrators/image_motion.h"

namespace lacquer {

namespace {

constexpr int kTileSize = 16;
constexpr int kFirstPass = 8, kLongestPass = 64;
/// Units of progress under a time limit.
constexpr int64_t kTimedUnits = 10000;
constexpr int kTimedHalfBlock = 4, kLongestHalfBlock = 16;
/// Tells the random numbers of albedos and passes from those of the path.
constexpr int kAlbedoStream = 1, kPassStream = 2;

/// Samples of pixels.
struct SampleTotals {
    int least = std::numeric_limits<int>::max(), most = 0;
    int64_t sum = 0;
    void Add(int count) {
        least = std::min(least, count);
        most = std::max(most, count);
        sum += count;
    }
};

/// What one thread needs to render; on its own cache lines.
struct alignas(128) Worker {
    Worker(const Sampler& prototype, bool wantAlbedo) : sampler(prototype.Clone()), recorder(wantAlbedo) {}
    std::unique_ptr<Sampler> sampler;
    ThreadState state;
    FirstHitRecorder recorder;
    std::optional<PassRecorder> passes;
    int64_t samples = 0;
};

class RenderLoop {
  public:
    RenderLoop(const Scene& scene, const Integrator& integrator, const Sampler& sampler, Film& film,
               const RenderOptions& options, Observer& observer)
        : scene_(scene),
          integrator_(integrator),
          sampler_(sampler),
          film_(film),
          options_(options),
          observer_(observer),
          isTimed_(std::isfinite(options.timeLimit)),
          filmNeeds_(film.Needs().any) {
        needs_ = film.Needs() | (options.aovs ? options.aovs->Needs() : FirstHitNeeds());
        for (int i = 0; i < MaxThreads(); ++i)
            workers_.push_back(std::make_unique<Worker>(sampler, needs_.albedo));
        if (needs_.any || needs_.coverage || needs_.motion)
            for (auto& worker : workers_) worker->state.firstHit = &worker->recorder;
        for (size_t i = 0; options.passes && i < workers_.size(); ++i)
            workers_[i]->state.passes = &workers_[i]->passes.emplace(*options.passes);
        if (integrator.MakesSplats()) {
            film.PrepareForSplats(MaxThreads());
            for (auto& worker : workers_) worker->state.film = &film;
        }
        // A render that ends by the clock does not know how many samples it will have, and all can be
        // stopped.
        film.SetHalves(HalvesOf(options));
        if (options.aovs) options.aovs->SetHalves(film.Halves());
        if (needs_.motion) motion_.emplace(scene);
        if (needs_.slopes) slopes_.emplace(scene.Camera(), scene.Resolution(), 1.f);
    }

    RenderStats Run() {
        start_ = Clock::now();
        lastCheckpoint_ = start_;
        checkpointInterval_ = options_.checkpointInterval;
        const int count = options_.endSample - options_.firstSample;
        if (!options_.resumes) before_ = film_.SampleCounts();
        const SampleTotals before = CountSamples();
        goal_ = int64_t(count) * film_.PixelBounds().Area() - before.sum;
        observer_.Begin("Rendering", isTimed_ ? kTimedUnits : goal_, isTimed_ ? "" : "samples");
        int done = before.least;
        while (done < count && !observer_.ShouldStop()) {
            const int pass = PassLength(done, count);
            if (pass == 0) break;
            const int first = options_.firstSample + done;
            if (!RenderPass(first, first + pass, done > 0 && !KeepsToGoodCounts(done))) break;
            done += pass;
            AfterPass(done);
        }
        RenderStats stats;
        stats.seconds = Elapsed();
        observer_.End();
        stats.interrupted = done < count && observer_.ShouldStop();
        stats.timedOut = done < count && !stats.interrupted;
        const SampleTotals after = CountSamples();
        stats.samplesPerPixel = after.least;
        stats.maxSamples = after.most;
        stats.samples = after.sum;
        stats.threads = AllowedThreads();
        for (const auto& worker : workers_) {
            stats.cameraRays += worker->state.cameraRays;
            stats.raysTraced += worker->state.rays.nearest;
            stats.shadowRays += worker->state.rays.shadow;
            stats.badSamples += worker->state.badSamples;
            stats.pathLengthSum += worker->state.pathLengthSum;
            stats.bxdf += worker->state.bxdf;
        }
        return stats;
    }

  private:
    static Halves HalvesOf(const RenderOptions& options) {
        if (options.halfBlock > 0) return {options.halfBlock, options.firstSample};
        if (std::isfinite(options.timeLimit)) return {kTimedHalfBlock, 0};
        return {BestHalfBlock(options.endSample - options.firstSample), 0};
    }

    /// Samples of the range that a pixel has.
    int Taken(Int2 pixel) const {
        const Bounds2i b = film_.PixelBounds();
        const Int2 q = pixel - b.min;
        const size_t i = size_t(q.y) * size_t(b.Width()) + size_t(q.x);
        return film_.SampleCount(pixel) - (before_.empty() ? 0 : before_[i]);
    }
    SampleTotals CountSamples() const {
        SampleTotals totals;
        const Bounds2i b = film_.PixelBounds();
        for (int y = b.min.y; y < b.max.y; ++y)
            for (int x = b.min.x; x < b.max.x; ++x) totals.Add(Taken({x, y}));
        return totals;
    }

    /// Seconds of rendering so far.
    double Elapsed() const { return SecondsSince(start_) - secondsBetweenPasses_; }

    /// False of samplers that like all counts alike: their limits fall where they may.
    bool KeepsToGoodCounts(int done) const {
        const bool prefersSome = sampler_.NextGoodCount(4) > 5;
        return options_.stopsAtGoodCounts && prefersSome && done < kFreeCounts;
    }

    /// Samples to the next good count; 0 if the time does not suffice for them.
    int PassToGoodCount(int done, int count) const {
        const int pass = std::min(sampler_.NextGoodCount(done), count) - done;
        return Elapsed() + pass * secondsPerSample_ > options_.timeLimit ? 0 : pass;
    }

    /// Samples of the next pass; 0 if the time is over. The first pass always runs.
    int PassLength(int done, int count) {
        if (!isTimed_) return std::min({done == 0 ? kFirstPass : 3 * done, kLongestPass, count - done});
        if (done == 0) return 1;
        if (KeepsToGoodCounts(done)) return PassToGoodCount(done, count);
        const int pass = std::min({done, kLongestPass, count - done});
        const double secondsLeft = options_.timeLimit - Elapsed();
        if (secondsLeft <= 0) return 0;
        // Half of what the speed of the last pass promises: the machine may have other things to do soon.
        const double room = secondsLeft / std::max(secondsPerSample_, 1e-12) / 2;
        // The limit falls into the shortest kind of pass: an eighth of the samples make no visible
        // difference, and up to eight at once cost little more than one where samplers work on blocks of
        // eight.
        const int shortest = std::clamp(done / 8, 1, 8);
        return std::min(pass, std::max(shortest, int(std::min(room, double(kLongestPass)))));
    }

    /// @param canTimeOut  false for the pass that must be whole
    /// False if it was stopped half-way.
    bool RenderPass(int first, int end, bool canTimeOut) {
        const double began = Elapsed();
        canTimeOut &= isTimed_;
        std::atomic<bool> stopped = false, pauses = false;
        const auto shouldStop = [&] {
            if (!stopped && (observer_.ShouldStop() || scene_.TexturesFailed() ||
                             (canTimeOut && Elapsed() >= options_.timeLimit)))
                stopped = true;
            if (!pauses && CheckpointIsDue()) pauses = true;
            return stopped || pauses;
        };
        const TileOrder order = canTimeOut ? TileOrder::Scattered : TileOrder::Rows;
        do {
            if (pauses.exchange(false)) Checkpoint();
            ParallelTiles(film_.PixelBounds(), kTileSize, order, [&](const Bounds2i& tile) {
                Worker& worker = *workers_[size_t(ThreadIndex())];
                const int64_t before = worker.samples;
                for (int y = tile.min.y; y < tile.max.y && !shouldStop(); ++y)
                    for (int x = tile.min.x; x < tile.max.x && !shouldStop(); ++x)
                        RenderPixel({x, y}, end, worker);
                Advance(worker.samples - before);
            });
        } while (pauses && !stopped);
        scene_.CheckTextures();
        secondsPerSample_ = (Elapsed() - began) / (end - first);
        return !stopped;
    }

    bool CheckpointIsDue() const {
        return options_.checkpoint && SecondsSince(lastCheckpoint_) >= checkpointInterval_;
    }
    void Checkpoint() {
        const Clock::time_point start = Clock::now();
        options_.checkpoint(Elapsed());
        lastCheckpoint_ = Clock::now();
        const double seconds = SecondsSince(start);
        secondsBetweenPasses_ += seconds;
        checkpointInterval_ = std::max(options_.checkpointInterval, seconds / options_.checkpointShare);
    }

    void AfterPass(int done) {
        if (!options_.afterPass) return;
        const Clock::time_point start = Clock::now();
        options_.afterPass(done, Elapsed());
        secondsBetweenPasses_ += SecondsSince(start);
    }

    /// Tells the observer of `samples` more: as such, or as the part of the time limit that has passed.
    void Advance(int64_t samples) {
        if (!isTimed_) {
            observer_.Advance(samples);
            return;
        }
        const double bySamples = double(samplesDone_ += samples) / double(goal_);
        const double fraction = std::min(1.0, std::max(bySamples, Elapsed() / options_.timeLimit));
        const auto units = int64_t(fraction * kTimedUnits);
        int64_t told = unitsTold_;
        while (told < units && !unitsTold_.compare_exchange_weak(told, units)) {
        }
        if (told < units) observer_.Advance(units - told);
    }

    /// Takes the samples before `end` that the pixel does not have yet.
    void RenderPixel(Int2 pixel, int end, Worker& worker) {
        const int first = options_.firstSample + Taken(pixel);
        if (first >= end) return;
        worker.samples += end - first;
        const auto takeSamples = [&] {
            for (int sample = first; sample < end; ++sample) RenderSample(pixel, sample, worker);
        };
        if (options_.pixelStats)
            options_.pixelStats->Measure(pixel, worker.state, takeSamples);
        else
            takeSamples();
    }

    void RenderSample(Int2 pixel, int index, Worker& worker) {
        Sampler& sampler = *worker.sampler;
        ThreadState& state = worker.state;
        sampler.StartPixelSample(pixel, index);
        state.rng = Rng(Hash(options_.seed, pixel.x, pixel.y, index));
        state.dimensions = BxDFDimensions(sampler);

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
        if (state.firstHit)
            worker.recorder.Start(Hash(options_.seed, pixel.x, pixel.y, kAlbedoStream), index);
        if (state.passes) state.passes->Start(Hash(options_.seed, pixel.x, pixel.y, index, kPassStream));
        if (ray) {
            ++state.cameraRays;
            L = integrator_.Li(*ray, lambda, sampler, state) * ray->weight;
        }
        if (!film_.AddSample(pixel, L, lambda, filter.weight)) {
            ++state.badSamples;
            L = SampledSpectrum(0);
        } else if (state.passes && ray) {
            state.passes->Scale(ray->weight);
            film_.AddPasses(pixel, L, state.passes->Sums(), lambda, filter.weight);
        }
        AddFirstHit(pixel, ray, L, lambda, filter.weight, worker);
        state.arena.Reset();
    }

    /// Hands the sample to those who want more than its radiance.
    void AddFirstHit(Int2 pixel, const std::optional<CameraRay>& ray, SampledSpectrum L,
                     const SampledWavelengths& lambda, float weight, Worker& worker) {
        FirstHit& hit = worker.recorder.Last();
        if (slopes_ && ray && hit.hit) {
            SurfaceInteraction si;
            si.p = hit.p;
            si.n = hit.n;
            slopes_->AtFirstHit(*ray, &si);
            hit.dpdx = si.dpdx;
            hit.dpdy = si.dpdy;
        }
        if (motion_ && ray) hit.motion = motion_->Of(hit, ray->ray);
        if (options_.aovs) options_.aovs->Add(pixel, hit, L, lambda, Vec3(0), weight);
        if (filmNeeds_) film_.AddFirstHit(pixel, hit, L, lambda);
    }

    const Scene& scene_;
    const Integrator& integrator_;
    const Sampler& sampler_;
    Film& film_;
    const RenderOptions& options_;
    Observer& observer_;
    const bool isTimed_;
    const bool filmNeeds_;
    FirstHitNeeds needs_;                       ///< of film and outputs together
    std::optional<FootprintEstimator> slopes_;  ///< of whole pixels, whatever the samples
    std::optional<ImageMotion> motion_;
    std::vector<std::unique_ptr<Worker>> workers_;
    Clock::time_point start_, lastCheckpoint_;
    double checkpointInterval_ = 0;  ///< until the next one [s]
    double secondsBetweenPasses_ = 0, secondsPerSample_ = 0;
    int64_t goal_ = 0;         ///< samples to take
    std::vector<int> before_;  ///< samples of each pixel that are none of this range; empty: all are
    std::atomic<int64_t> samplesDone_ = 0, unitsTold_ = 0;
};

}  // namespace

int BestHalfBlock(int samples) { return std::min(kLongestHalfBlock, HalfBlockOf(samples)); }

RenderStats Render(const Scene& scene, const Integrator& integrator, const Sampler& sampler, Film& film,
                   const RenderOptions& options, Observer& observer) {
    return RenderLoop(scene, integrator, sampler, film, options, observer).Run();
}

}  // namespace lacquer
