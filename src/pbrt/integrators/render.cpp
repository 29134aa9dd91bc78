#include "pbrt/integrators/render.h"

#include <atomic>

#include "pbrt/core/check.h"
#include "pbrt/core/clock.h"
#include "pbrt/core/parallel.h"
#include "pbrt/film/pass_recorder.h"
#include "pbrt/guiding/path_guide.h"
#include "pbrt/integrators/footprint.h"
#include "pbrt/integrators/guide_plan.h"
#include "pbrt/integrators/guide_trial.h"
#include "pbrt/integrators/image_motion.h"
#include "pbrt/integrators/noise_level.h"
#include "pbrt/samplers/low_discrepancy.h"

namespace lacquer {

namespace {

constexpr int kTileSize = 16;
constexpr int kFirstPass = 8, kLongestPass = 64;
/// Units of progress under a time limit.
constexpr int64_t kTimedUnits = 10000;
constexpr int kUnevenHalfBlock = 4, kLongestHalfBlock = 16;
constexpr int kFirstNoiseCount = 16;
/// Tells the random numbers of albedos and passes from those of the path.
constexpr int kAlbedoStream = 1, kPassStream = 2, kGuideStream = 4;

/// Halves are even where a pixel has a multiple of this many samples, if noise is looked at. With shares, it
/// is the least one of which each pixel has a block in either.
constexpr int NoiseUnit(bool hasShares) {
    return 2 * kNoiseHalfBlock * (hasShares ? SampleShares::kUnit : 1);
}

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
          cameraNumbers_(scene),
          options_(options),
          observer_(observer),
          isTimed_(std::isfinite(options.timeLimit)),
          filmNeeds_(film.Needs().any) {
        needs_ = film.Needs() | (options.aovs ? options.aovs->Needs() : FirstHitNeeds());
        for (int i = 0; i < MaxThreads(); ++i)
            workers_.push_back(std::make_unique<Worker>(sampler, needs_.albedo));
        RecordFirstHits(needs_.any || needs_.coverage || needs_.motion);
        for (size_t i = 0; options.passes && i < workers_.size(); ++i)
            workers_[i]->state.passes = &workers_[i]->passes.emplace(*options.passes);
        // Shares give pixels different samples.
        LACQUER_CHECK(!(integrator.SharesSamples() && options.shares));
        if (integrator.MakesSplats()) {
            film.PrepareForSplats(MaxThreads());
            for (auto& worker : workers_) worker->state.film = &film;
        }
        if (integrator.UsesChains()) {
            LACQUER_CHECK(options.firstSample == 0 && !options.resumes && !options.checkpoint &&
                          !options.pixelStats && !options.shares && options.noiseTarget <= 0);
            chains_ = integrator.MakeChains(film, options.seed, options.jitter);
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
        const SampleSpan before = Span();
        if (integrator_.UsesGuide()) LearnGuide(count);
        goal_ = SamplesOfAll(count) - TakenByAll();
        if (chains_ && !StartChains()) return StoppedBefore();
        observer_.Begin("Rendering", isTimed_ ? kTimedUnits : goal_, isTimed_ ? "" : "samples");
        RenderStats stats;
        stats.wasGuided = usesGuide_;
        int done = std::min(before.least, count);
        // Some pixels have more where a pass was begun: after a look that was to go on.
        bool mayLook = before.most <= done;
        while (done < count && !observer_.ShouldStop() && !(mayLook && IsQuietEnough(done, &stats))) {
            mayLook = true;
            const int pass = PassLength(done, count);
            if (pass == 0) break;
            if (!RenderPass(done, done + pass, done > 0 && !KeepsToGoodCounts(done))) break;
            done += pass;
            AfterPass(done);
        }
        if (done == count) IsQuietEnough(done, &stats);
        stats.seconds = Elapsed();
        observer_.End();
        stats.interrupted = done < count && observer_.ShouldStop();
        stats.timedOut = done < count && !stats.interrupted && !stats.reachedNoise;
        const SampleSpan span = Span();
        stats.samplesPerPixel = std::min(span.least, count);
        stats.maxSamples = std::max(span.most, stats.samplesPerPixel);
        stats.samples = TakenByAll();
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
    Halves HalvesOf(const RenderOptions& options) const {
        if (options.noiseTarget > 0) return {kNoiseHalfBlock, options.firstSample, FirstSamples(), true};
        if (options.halfBlock > 0) return {options.halfBlock, options.firstSample, FirstSamples()};
        if (isTimed_) return {kUnevenHalfBlock, 0};
        return {BestHalfBlock(options.endSample - options.firstSample, options.shares != nullptr), 0};
    }
    /// Of each pixel; null if all begin with the same one.
    std::shared_ptr<const std::vector<int>> FirstSamples() const {
        if (!options_.shares || options_.firstSample == 0) return nullptr;
        auto firsts = std::make_shared<std::vector<int>>();
        const Bounds2i b = film_.PixelBounds();
        for (int y = b.min.y; y < b.max.y; ++y)
            for (int x = b.min.x; x < b.max.x; ++x) firsts->push_back(int(EndOf({x, y}, 0)));
        return firsts;
    }

    /// Number of the first sample of a pixel behind `samples` of the range.
    int64_t EndOf(Int2 pixel, int samples) const {
        const int end = options_.firstSample + samples;
        return options_.shares ? options_.shares->SamplesOf(pixel, end) : end;
    }
    /// Samples of the range that a pixel has.
    int Taken(Int2 pixel) const {
        const Bounds2i b = film_.PixelBounds();
        const Int2 q = pixel - b.min;
        const size_t i = size_t(q.y) * size_t(b.Width()) + size_t(q.x);
        return film_.SampleCount(pixel) - (before_.empty() ? 0 : before_[i]);
    }
    std::vector<int> TakenByEach() const {
        std::vector<int> taken = film_.SampleCounts();
        for (size_t i = 0; i < before_.size(); ++i) taken[i] -= before_[i];
        return taken;
    }
    int64_t TakenByAll() const {
        int64_t sum = 0;
        for (const int taken : TakenByEach()) sum += taken;
        return sum;
    }
    SampleSpan Span() const {
        return SampleSpanOf(TakenByEach(), film_.PixelBounds(), options_.shares, options_.firstSample);
    }
    /// That all pixels take of so many samples.
    int64_t SamplesOfAll(int samples) const {
        const Bounds2i b = film_.PixelBounds();
        if (!options_.shares) return int64_t(samples) * b.Area();
        int64_t sum = 0;
        for (int y = b.min.y; y < b.max.y; ++y)
            for (int x = b.min.x; x < b.max.x; ++x) sum += EndOf({x, y}, samples) - EndOf({x, y}, 0);
        return sum;
    }

    /// The least count above `done` after which noise is looked at: 16, 32, 64, 96, 128, 192, ... samples.
    int NextNoiseCount(int done) const {
        const int unit = NoiseUnit(options_.shares != nullptr);
        return std::max(unit * NextCountOfNets(done / unit), kFirstNoiseCount);
    }
    /// Looks at the noise if `done` is such a count. The decision depends on all pixels together and hardly
    /// on any one of them: what it takes from their independence cannot be measured.
    bool IsQuietEnough(int done, RenderStats* stats) const {
        if (options_.noiseTarget <= 0 || done == 0 || NextNoiseCount(done - 1) != done) return false;
        stats->noise = NoiseLevel(film_);
        stats->noiseSamples = done;
        stats->reachedNoise = *stats->noise <= options_.noiseTarget;
        return stats->reachedNoise;
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
    int PassLength(int done, int count) const {
        if (options_.noiseTarget > 0)
            return std::min(UsualPassLength(done, count), NextNoiseCount(done) - done);
        return UsualPassLength(done, count);
    }
    /// Where nobody looks at the noise.
    int UsualPassLength(int done, int count) const {
        if (options_.tileOfOnePass > 0) return count - done;
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

    /// The samples [first, end) of the range.
    /// @param canTimeOut  false for the pass that must be whole
    /// False if it was stopped half-way.
    bool RenderPass(int first, int end, bool canTimeOut) {
        const double began = Elapsed();
        canTimeOut &= isTimed_;
        if (chains_) {
            const bool isWhole = RunChains(end, canTimeOut);
            secondsPerSample_ = (Elapsed() - began) / (end - first);
            return isWhole;
        }
        std::atomic<bool> stopped = false, pauses = false;
        const auto shouldStop = [&] {
            if (!stopped && (observer_.ShouldStop() || scene_.TexturesFailed() ||
                             (canTimeOut && Elapsed() >= options_.timeLimit)))
                stopped = true;
            if (!pauses && CheckpointIsDue()) pauses = true;
            return stopped || pauses;
        };
        const TileOrder order = canTimeOut ? TileOrder::Scattered : TileOrder::Rows;
        const int tileSize = options_.tileOfOnePass > 0 ? options_.tileOfOnePass : kTileSize;
        // Samples of one number share what was made for them.
        const int step = integrator_.SharesSamples() ? 1 : end - first;
        for (int done = first + step; done <= end && !stopped; done += step) {
            ShareSample(options_.firstSample + done - 1, [&] { return shouldStop() && stopped; });
            do {
                if (pauses.exchange(false)) Checkpoint();
                ParallelTiles(film_.PixelBounds(), tileSize, order, [&](const Bounds2i& tile) {
                    Worker& worker = *workers_[size_t(ThreadIndex())];
                    const int64_t before = worker.samples;
                    for (int y = tile.min.y; y < tile.max.y && !shouldStop(); ++y)
                        for (int x = tile.min.x; x < tile.max.x && !shouldStop(); ++x)
                            RenderPixel({x, y}, int(EndOf({x, y}, done)), worker);
                    Advance(worker.samples - before);
                });
            } while (pauses && !stopped);
        }
        scene_.CheckTextures();
        secondsPerSample_ = (Elapsed() - began) / (end - first);
        return !stopped;
    }

    ChainWork WorkOfChains(const std::function<bool()>& shouldStop,
                           const std::function<void(int64_t)>& advance) {
        const auto state = [this]() -> ThreadState& { return workers_[size_t(ThreadIndex())]->state; };
        return {state, shouldStop, advance};
    }
    /// False if it was stopped.
    bool StartChains() {
        observer_.Begin("Bootstrap", chains_->NumStartPaths(), "paths");
        const ChainWork work =
            WorkOfChains([this] { return observer_.ShouldStop() || scene_.TexturesFailed(); },
                         [this](int64_t paths) { observer_.Advance(paths); });
        const bool isRecording = workers_[0]->state.firstHit != nullptr;
        RecordFirstHits(false);
        const bool isWhole = chains_->Start(work, observer_);
        RecordFirstHits(isRecording);
        observer_.End();
        scene_.CheckTextures();
        return isWhole;
    }
    static RenderStats StoppedBefore() {
        RenderStats stats;
        stats.interrupted = true;
        stats.threads = AllowedThreads();
        return stats;
    }

    /// Chains go on to `end` samples of each pixel, and pixels take as many as there were mutations. False if
    /// it was stopped half-way.
    bool RunChains(int end, bool canTimeOut) {
        const Bounds2i bounds = film_.PixelBounds();
        const int64_t pixels = bounds.Area();
        const auto shouldStop = [&] {
            return observer_.ShouldStop() || scene_.TexturesFailed() ||
                   (canTimeOut && Elapsed() >= options_.timeLimit);
        };
        const bool isRecording = workers_[0]->state.firstHit != nullptr;
        RecordFirstHits(false);
        const int64_t mutations = chains_->Run(
            end * pixels, WorkOfChains(shouldStop, [this](int64_t samples) { Advance(samples); }));
        RecordFirstHits(isRecording);
        scene_.CheckTextures();
        ParallelTiles(bounds, kTileSize, TileOrder::Rows, [&](const Bounds2i& tile) {
            Worker& worker = *workers_[size_t(ThreadIndex())];
            for (int y = tile.min.y; y < tile.max.y; ++y)
                for (int x = tile.min.x; x < tile.max.x; ++x) {
                    const int64_t i = int64_t(y - bounds.min.y) * bounds.Width() + (x - bounds.min.x);
                    RenderPixel({x, y}, int((mutations + pixels - 1 - i) / pixels), worker);
                }
        });
        return mutations == end * pixels;
    }
    /// Of camera samples; paths of chains are none.
    void RecordFirstHits(bool record) {
        for (auto& worker : workers_) worker->state.firstHit = record ? &worker->recorder : nullptr;
    }

    /// Has the integrator make what the samples of one number share.
    void ShareSample(int index, const std::function<bool()>& isStopped) {
        if (!integrator_.SharesSamples()) return;
        shared_.reset();  // two of them need not fit into memory
        shared_ = integrator_.ShareSample(
            {.film = film_,
             .index = index,
             .seed = options_.seed,
             .drawsWavelengths = options_.jitter.wavelengths,
             .drawsTime = options_.jitter.pixels,
             .state = [this]() -> ThreadState& { return workers_[size_t(ThreadIndex())]->state; },
             .isStopped = isStopped});
        for (auto& worker : workers_) worker->state.shared = shared_.get();
    }

    /// Whatever part of an image is rendered, and whatever it has already, the guide is the same: samples
    /// that this render does not take are followed all the same.
    void LearnGuide(int count) {
        const int samples = options_.plannedSamples > 0 ? options_.plannedSamples : options_.endSample;
        const GuidePlan plan(scene_.Resolution(), samples);
        if (plan.NumPasses() == 0) return;
        guide_ = std::make_unique<PathGuide>(scene_.Bounds());
        SetGuide(guide_.get());
        observer_.Begin("Learning to guide paths", plan.NumSamples(), "samples");
        usesGuide_ = LearnPasses(plan, samples, count) && guide_->IsUsed();
        SetGuide(usesGuide_ ? guide_.get() : nullptr);
        observer_.End();
        scene_.CheckTextures();
    }
    void SetGuide(PathGuide* guide) {
        for (auto& worker : workers_) worker->state.guide = guide;
    }

    /// False if what was learned is not worth its time, which an early look tells of most scenes.
    bool LearnPasses(const GuidePlan& plan, int samples, int count) {
        GuideTrial trial(scene_.Resolution(), options_.seed);
        for (int pass = 0; pass < plan.NumPasses(); ++pass) {
            const bool goesOn = LearnPass(plan, pass, count);
            const bool isLast = !goesOn || pass + 1 == plan.NumPasses() || Elapsed() > options_.timeLimit / 8;
            guide_->EndPass(isLast);
            if (!goesOn) return false;
            if (isLast && !options_.triesGuide) return true;
            if (!isLast && (!options_.triesGuide || pass + 3 != plan.NumPasses())) continue;
            // At the end, or early: of a quarter of the samples.
            const int lastPass = isLast ? pass : plan.NumPasses() - 1;
            const GuideTrial::Length length{.samples = SamplesOfTrial(plan, pass, samples, trial),
                                            .learned = plan.SamplesOfPixel(lastPass)};
            if (!length.IsEnough()) {
                if (isLast) return false;
                continue;
            }
            guide_->SetLearning(false);
            const std::optional<GuideTrial::Gain> gain = TryGuide(length, &trial);
            if (!gain) return false;
            if (isLast) return gain->AtLeast() >= gain->cost;
            if (gain->value < GuideTrial::kMinPromise) return false;
            guide_->SetLearning(true);
        }
        return false;
    }
    /// As many as there is time for, if that is limited.
    int SamplesOfTrial(const GuidePlan& plan, int pass, int samples, const GuideTrial& trial) const {
        const int most = trial.MostSamples(samples);
        if (!isTimed_) return most;
        constexpr double kPartOfTime = 0.05;
        const double perSecond = double(plan.SamplesUpTo(pass)) / std::max(Elapsed(), 1e-3);
        const double inTime = kPartOfTime * options_.timeLimit * perSecond;
        return int(std::min(double(most), inTime / (2. * GuideTrial::kSets * double(trial.NumPixels()))));
    }

    /// By sets of this length. Empty if nothing was learned, or if it was stopped.
    std::optional<GuideTrial::Gain> TryGuide(GuideTrial::Length length, GuideTrial* trial) {
        if (!guide_->IsUsed()) return std::nullopt;
        const bool isFirstLook = trial->LengthOfSets() != length;
        std::atomic<bool> stopped = false;
        ParallelFor(int64_t(trial->NumPixels()), [&](int64_t i) {
            const auto k = size_t(i);
            Worker& worker = *workers_[size_t(ThreadIndex())];
            for (int number = 0; number < GuideTrial::kSets; ++number) {
                const auto lightOf = [&](PathGuide* guide, int first, int end, RayCounts* rays) {
                    worker.state.guide = guide;
                    *rays = {};
                    return LightOf(trial->PixelAt(k), trial->NumbersOf(k, number), first, end, rays, &stopped,
                                   worker);
                };
                GuideTrial::Set& set = trial->SetOf(k, number);
                if (isFirstLook) {
                    set.first = lightOf(nullptr, 0, length.learned, &set.rays);
                    set.rest = lightOf(nullptr, length.learned, length.samples, &set.rays);
                }
                set.guided = lightOf(guide_.get(), length.learned, length.samples, &set.guidedRays);
            }
        });
        SetGuide(guide_.get());
        if (stopped) return std::nullopt;
        trial->SetLength(length);
        return trial->GainOfGuide();
    }
    /// The sum of the samples [first, end) of a pixel, with the random numbers of another.
    glm::dvec3 LightOf(Int2 pixel, Int2 numbers, int first, int end, RayCounts* rays,
                       std::atomic<bool>* stopped, Worker& worker) {
        constexpr int kLook = 256;
        glm::dvec3 sum(0);
        for (int index = first; index < end && !*stopped; ++index) {
            if ((index - first) % kLook == 0 && (observer_.ShouldStop() || scene_.TexturesFailed()))
                *stopped = true;
            sum += glm::dvec3(film_.ColorSpace().ToRGB(FollowSample(pixel, index, numbers, worker, rays)));
        }
        return sum;
    }

    /// False if it was stopped.
    bool LearnPass(const GuidePlan& plan, int pass, int count) {
        std::atomic<bool> stopped = false;
        const int first = GuidePlan::FirstSample(pass), end = GuidePlan::EndSample(pass);
        ParallelTiles(plan.Blocks(), kTileSize, TileOrder::Rows, [&](const Bounds2i& tile) {
            Worker& worker = *workers_[size_t(ThreadIndex())];
            for (int y = tile.min.y; y < tile.max.y; ++y)
                for (int x = tile.min.x; x < tile.max.x; ++x) {
                    if (stopped || observer_.ShouldStop() || scene_.TexturesFailed()) {
                        stopped = true;
                        return;
                    }
                    const Rng rng(Hash(options_.seed, x, y, kGuideStream, 0));
                    LearnFromPixel(plan.PixelIn({x, y}, rng), first, end, count, worker);
                }
            observer_.Advance(int64_t(tile.Area()) * (end - first));
        });
        return !stopped;
    }
    /// From the samples [first, end), which count as far as they are the next ones of this render.
    void LearnFromPixel(Int2 pixel, int first, int end, int count, Worker& worker) {
        const bool isInFilm = film_.PixelBounds().Contains(pixel);
        for (int index = first; index < end; ++index) {
            const bool counts =
                isInFilm && index == EndOf(pixel, 0) + Taken(pixel) && index < EndOf(pixel, count);
            if (counts)
                TakeSamples(pixel, index, index + 1, worker);
            else
                FollowSample(pixel, index, pixel, worker);
        }
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
        const int first = int(EndOf(pixel, 0)) + Taken(pixel);
        if (first >= end) return;
        worker.samples += end - first;
        TakeSamples(pixel, first, end, worker);
    }
    void TakeSamples(Int2 pixel, int first, int end, Worker& worker) {
        const auto takeSamples = [&] {
            for (int sample = first; sample < end; ++sample) RenderSample(pixel, sample, worker);
        };
        if (options_.pixelStats)
            options_.pixelStats->Measure(pixel, worker.state, takeSamples);
        else
            takeSamples();
    }

    /// A camera sample, and the light that it finds. Its members are made where they are: copies of what was
    /// just written, in wider pieces, stall.
    struct FollowedSample {
        FollowedSample(RenderLoop& loop, Int2 pixel, int index, Int2 numbers, Worker& worker)
            : film(loop.StartSample(pixel, index, numbers, worker)),
              ray(loop.scene_.Camera().GenerateRay(film.camera)) {}

        FilmSample film;
        std::optional<CameraRay> ray;
        SampledSpectrum L{0.f};
    };
    FilmSample StartSample(Int2 pixel, int index, Int2 numbers, Worker& worker) {
        Sampler& sampler = *worker.sampler;
        ThreadState& state = worker.state;
        sampler.StartPixelSample(numbers, index);
        state.rng = Rng(Hash(options_.seed, numbers.x, numbers.y, index));
        state.dimensions = BxDFDimensions(sampler);
        FilmSample sample = SampleFilm(film_, pixel, options_.jitter, cameraNumbers_, sampler);
        if (state.shared) sample.camera.time = state.shared->Time();
        return sample;
    }
    /// What it returns is valid until the arena is reset.
    /// @param numbers  pixel whose random numbers it has
    FollowedSample Follow(Int2 pixel, int index, Int2 numbers, Worker& worker) {
        Sampler& sampler = *worker.sampler;
        ThreadState& state = worker.state;
        FollowedSample followed(*this, pixel, index, numbers, worker);
        if (state.firstHit)
            worker.recorder.Start(Hash(options_.seed, pixel.x, pixel.y, kAlbedoStream), index);
        if (state.passes) state.passes->Start(Hash(options_.seed, pixel.x, pixel.y, index, kPassStream));
        if (followed.ray) {
            ++state.cameraRays;
            followed.L =
                integrator_.Li(*followed.ray, followed.film.lambda, sampler, state) * followed.ray->weight;
        }
        return followed;
    }
    /// For what a guide learns from it alone: statistics do not have it. @param rays  takes its rays; or null
    XYZ FollowSample(Int2 pixel, int index, Int2 numbers, Worker& worker, RayCounts* rays = nullptr) {
        ThreadState& state = worker.state;
        const auto counts =
            std::tuple(state.cameraRays, state.rays, state.badSamples, state.pathLengthSum, state.bxdf);
        state.rays = {};
        const FollowedSample followed = Follow(pixel, index, numbers, worker);
        if (rays) {
            rays->nearest += state.rays.nearest;
            rays->shadow += state.rays.shadow;
        }
        std::tie(state.cameraRays, state.rays, state.badSamples, state.pathLengthSum, state.bxdf) = counts;
        state.arena.Reset();
        return XYZOf(followed.film, followed.L, film_);
    }

    void RenderSample(Int2 pixel, int index, Worker& worker) {
        auto [sample, ray, L] = Follow(pixel, index, pixel, worker);
        ThreadState& state = worker.state;
        if (!film_.AddSample(pixel, L, sample.lambda, sample.weight)) {
            ++state.badSamples;
            L = SampledSpectrum(0);
        } else if (state.passes && ray) {
            state.passes->Scale(ray->weight);
            film_.AddPasses(pixel, L, state.passes->Sums(), sample.lambda, sample.weight);
        }
        AddFirstHit(pixel, ray, L, sample.lambda, sample.weight, worker);
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
    const CameraNumbers cameraNumbers_;
    const RenderOptions& options_;
    Observer& observer_;
    const bool isTimed_;
    const bool filmNeeds_;
    FirstHitNeeds needs_;                       ///< of film and outputs together
    std::optional<FootprintEstimator> slopes_;  ///< of whole pixels, whatever the samples
    std::optional<ImageMotion> motion_;
    std::vector<std::unique_ptr<Worker>> workers_;
    std::unique_ptr<MarkovChains> chains_;  ///< null: camera samples find the light
    std::unique_ptr<const SharedSample> shared_;
    std::unique_ptr<PathGuide> guide_;  ///< null: paths go by scattering alone
    bool usesGuide_ = false;
    Clock::time_point start_, lastCheckpoint_;
    double checkpointInterval_ = 0;  ///< until the next one [s]
    double secondsBetweenPasses_ = 0, secondsPerSample_ = 0;
    int64_t goal_ = 0;         ///< samples to take
    std::vector<int> before_;  ///< samples of each pixel that are none of this range; empty: all are
    std::atomic<int64_t> samplesDone_ = 0, unitsTold_ = 0;
};

}  // namespace

SampleSpan SampleSpanOf(const std::vector<int>& taken, const Bounds2i& pixels, const SampleShares* shares,
                        int first) {
    if (!shares) {
        const auto [least, most] = std::minmax_element(taken.begin(), taken.end());
        return {*least, *most};
    }
    SampleSpan span{std::numeric_limits<int>::max(), 0};
    size_t i = 0;
    for (int y = pixels.min.y; y < pixels.max.y; ++y)
        for (int x = pixels.min.x; x < pixels.max.x; ++x, ++i) {
            const int64_t end = shares->SamplesOf({x, y}, first) + taken[i];
            span.least = std::min(span.least, shares->MostOf({x, y}, end) - first);
            span.most = std::max(span.most, shares->LeastOf({x, y}, end) - first);
        }
    return span;
}

int FirstNoiseCount(bool hasShares) { return std::max(NoiseUnit(hasShares), kFirstNoiseCount); }

int BestHalfBlock(int samples, bool isUneven) {
    if (!isUneven) return std::min(kLongestHalfBlock, HalfBlockOf(samples));
    // Two blocks at least where a pixel has the least share of them.
    return std::clamp(HalfBlockOf(samples) / SampleShares::kUnit, 1, kUnevenHalfBlock);
}

RenderStats Render(const Scene& scene, const Integrator& integrator, const Sampler& sampler, Film& film,
                   const RenderOptions& options, Observer& observer) {
    return RenderLoop(scene, integrator, sampler, film, options, observer).Run();
}

}  // namespace lacquer
