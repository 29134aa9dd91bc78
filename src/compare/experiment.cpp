#include "compare/experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <stdexcept>

#include "compare/flip.h"
#include "denoise/method.h"
#include "pbrt/core/check.h"
#include "pbrt/core/clock.h"
#include "pbrt/core/rng.h"
#include "pbrt/integrators/render.h"
#include "pbrt/integrators/rendered_image.h"
#include "pbrt/scene/builder.h"

namespace lacquer::compare {

namespace {

/// More samples per pixel than time limits reach.
constexpr int kUnlimitedSamples = 1 << 16;
/// Textures are filtered alike in all renders, however many samples they take: as for the reference.
constexpr int kFilterSamples = 64;
/// Seeds of the reference's parts are this far from those of the runs.
constexpr int kReferenceSeeds = 1 << 20;

/// Of the render that shows what denoising takes.
constexpr int kTrialSamples = 4;
/// Denoising may take this part of a run's time.
constexpr double kMaxDenoiseShare = 0.9;

/// Passes everything on, but calls all work by one name and does not repeat the loader's warnings.
class NamedObserver final : public Observer {
  public:
    NamedObserver(Observer& observer, std::string name) : observer_(observer), name_(std::move(name)) {}
    void Begin(const std::string&, int64_t total, const std::string& unit) override {
        observer_.Begin(name_, total, unit);
    }
    void Advance(int64_t units) override { observer_.Advance(units); }
    void End() override { observer_.End(); }
    bool ShouldStop() override { return observer_.ShouldStop(); }

  private:
    Observer& observer_;
    std::string name_;
};

/// The scene with random numbers of its own: what fixes or switches off those of the sampler is taken out.
SceneDescription WithSeed(SceneDescription scene, int seed) {
    scene.options.Set(&SceneOptions::seed, seed);
    std::erase_if(scene.sampler.parameters, [](const Parameter& p) {
        const bool isOff = p.name == "randomization" && p.strings == std::vector<std::string>{"none"};
        return isOff || p.name == "seed" || p.name == "jitter";
    });
    return scene;
}

std::vector<std::string> AovsOf(const Candidate& candidate) {
    if (!IsDenoised(candidate)) return {};
    return denoise::AovsOf(denoise::MethodOf(candidate.name));
}

BuildOptions OptionsOf(const ExperimentPlan& plan, const Candidate& candidate, const Budget& budget) {
    BuildOptions options;
    options.film = plan.film;
    options.textures = plan.textures;
    options.materials = OverridesOf(candidate);
    options.samplesPerPixel = budget.seconds ? kUnlimitedSamples : budget.samplesPerPixel;
    options.filterSamples = kFilterSamples;
    options.film.keepsHalves = IsDenoised(candidate) && AovBuffer::NeedsHalves(AovsOf(candidate));
    return options;
}

void AddStage(std::vector<Stage>* stages, const Reference& reference, const Image& image, int samples,
              double seconds) {
    auto stage =
        std::find_if(stages->begin(), stages->end(), [&](const Stage& s) { return s.samples == samples; });
    if (stage == stages->end()) {
        stages->push_back(
            {samples, 0, 0,
             std::vector<float>(size_t(image.Resolution().x) * size_t(image.Resolution().y), 0.f)});
        stage = stages->end() - 1;
    }
    const std::vector<float> squares = SquaredErrors(image, reference.image);
    for (size_t i = 0; i < squares.size(); ++i) stage->squares[i] += squares[i];
    stage->seconds += seconds;
    ++stage->runs;
}

/// The colours of a render; denoised, if the candidate does that. Errors: OverrideError.
Image ColorsOf(const Candidate& candidate, const RenderSetup& setup, const AovBuffer* aovs,
               const RenderStats& stats, Observer* observer) {
    if (!IsDenoised(candidate)) return std::move(*setup.film->Develop());
    ImageOrigin origin;
    origin.samplesPerPixel = stats.samplesPerPixel;
    origin.showsSampleCounts = PixelsDiffer(stats);
    const std::unique_ptr<Image> image = DevelopRender(setup, aovs, nullptr, origin);
    try {
        denoise::DenoiseImage(denoise::MethodOf(candidate.name), image.get(), observer);
    } catch (const std::invalid_argument& e) {
        throw OverrideError("denoiser \"" + candidate.name + "\": a render " + e.what());
    }
    return image->OnlyChannels(
        [](const std::string& channel) { return channel == "R" || channel == "G" || channel == "B"; });
}

}  // namespace

RenderSetup Experiment::BuildOnce() const {
    return BuildScene(plan_.scene, OptionsOf(plan_, plan_.candidates.at(plan_.baseline), plan_.budget),
                      &observer_);
}

Experiment::Frame Experiment::FrameOf(const RenderSetup& setup) {
    return {setup.film->Resolution(), setup.film->PixelBounds(), &setup.film->ColorSpace()};
}

RenderedRun Experiment::Render(const Candidate& candidate, const Budget& budget, int seed,
                               const std::string& name,
                               const std::function<void(const Image&, int, double)>& atStage) const {
    const Clock::time_point start = Clock::now();
    NamedObserver observer(observer_, name);
    SceneDescription scene = plan_.scene;
    Apply(candidate, &scene);
    const RenderSetup setup =
        BuildScene(WithSeed(std::move(scene), seed), OptionsOf(plan_, candidate, budget), &observer);
    RenderedRun run;
    run.record.loadSeconds = SecondsSince(start);
    const std::unique_ptr<AovBuffer> aovs = MakeAovBuffer(AovsOf(candidate), 0, setup);
    RenderOptions options;
    options.aovs = aovs.get();
    options.endSample = setup.sampler->SamplesPerPixel();
    options.seed = seed;
    if (budget.seconds) {
        options.timeLimit = *budget.seconds;
        options.stopsAtGoodCounts = true;
    }
    options.jitter = {!setup.options.disablePixelJitter, !setup.options.disableWavelengthJitter};
    options.afterPass = [&](int samples, double seconds) {
        if (atStage && !IsDenoised(candidate) && std::has_single_bit(unsigned(samples)))
            atStage(*setup.film->Develop(), samples, seconds);
    };
    const RenderStats stats =
        lacquer::Render(*setup.scene, *setup.integrator, *setup.sampler, *setup.film, options, observer);
    run.interrupted = stats.interrupted;
    if (run.interrupted) return run;
    const Clock::time_point denoising = Clock::now();
    const Image colors = ColorsOf(candidate, setup, aovs.get(), stats, &observer);
    if (IsDenoised(candidate)) run.record.denoiseSeconds = SecondsSince(denoising);
    const std::vector<int> counts = setup.film->SampleCounts();
    run.image = colors.WithChannel("samples", {counts.begin(), counts.end()});
    LACQUER_CHECK(run.image.HasRGB());
    run.record.seed = seed;
    run.record.samplesPerPixel = double(stats.samples) / double(setup.film->PixelBounds().Area());
    run.record.minSamples = stats.samplesPerPixel;
    run.record.maxSamples = stats.maxSamples;
    run.record.seconds = stats.seconds + run.record.denoiseSeconds;
    run.record.badSamples = stats.badSamples;
    return run;
}

std::optional<Reference> Experiment::RenderReference() {
    Budget ofPart = plan_.reference.budget;
    if (ofPart.seconds) *ofPart.seconds /= kReferenceParts;
    ofPart.samplesPerPixel = (ofPart.samplesPerPixel + kReferenceParts - 1) / kReferenceParts;
    std::vector<Image> parts;
    double samples = 0;
    for (int part = 0; part < kReferenceParts; ++part) {
        const std::string name =
            "Reference, part " + std::to_string(part + 1) + " of " + std::to_string(kReferenceParts);
        RenderedRun run =
            Render(plan_.reference.candidate, ofPart, plan_.seed + kReferenceSeeds + part, name, {});
        if (run.interrupted) break;
        samples += run.record.samplesPerPixel;
        parts.push_back(std::move(run.image));
    }
    if (parts.size() < 2) return std::nullopt;
    Reference reference = ReferenceOfParts(parts);
    reference.renderedBy = plan_.reference.candidate.Label();
    reference.samplesPerPixel = samples;
    return reference;
}

std::vector<double> Experiment::TimeDenoisers() const {
    if (std::none_of(plan_.candidates.begin(), plan_.candidates.end(), IsDenoised)) return {};
    std::vector<double> seconds;
    for (const Candidate& candidate : plan_.candidates) {
        seconds.push_back(0);
        if (!IsDenoised(candidate)) continue;
        const Budget few{.seconds = {}, .samplesPerPixel = kTrialSamples};
        seconds.back() =
            Render(candidate, few, plan_.seed, "Time of " + candidate.Label(), {}).record.denoiseSeconds;
        if (plan_.budget.seconds && seconds.back() > kMaxDenoiseShare * *plan_.budget.seconds)
            throw OverrideError(fmt::format("--time {:g}: denoiser \"{}\" alone takes {:.2g} s of it",
                                            *plan_.budget.seconds, candidate.name, seconds.back()));
    }
    return seconds;
}

Budget Experiment::BudgetOf(size_t candidate) const {
    Budget budget = plan_.budget;
    if (budget.seconds && !denoiseSeconds_.empty())
        *budget.seconds -= std::min(denoiseSeconds_[candidate], kMaxDenoiseShare * *budget.seconds);
    return budget;
}

std::vector<CandidateResult> Experiment::Run(const Reference& reference) {
    std::vector<CandidateResult> results;
    for (const Candidate& candidate : plan_.candidates) results.push_back({candidate, {}, {}, {}, {}, {}});
    const size_t count = results.size();
    for (int run = 0; run < plan_.runs; ++run)
        for (size_t i = 0; i < count; ++i) {
            const size_t index = (i + size_t(run)) % count;
            CandidateResult& result = results[index];
            const std::string name = "Run " + std::to_string(run + 1) + " of " + std::to_string(plan_.runs) +
                                     ", " + result.candidate.Label();
            // Stages of an interrupted run do not count: they wait here until it is whole.
            std::vector<Stage> stages = result.stages;
            const int seed = plan_.seed + 1 + run * int(count) + int(index);
            RenderedRun rendered = Render(result.candidate, BudgetOf(index), seed, name,
                                          [&](const Image& image, int samples, double seconds) {
                                              AddStage(&stages, reference, image, samples, seconds);
                                          });
            if (rendered.interrupted) return results;
            if (!denoiseSeconds_.empty()) denoiseSeconds_[index] = rendered.record.denoiseSeconds;
            result.stages = std::move(stages);
            result.records.push_back(rendered.record);
            result.images.push_back(std::move(rendered.image));
        }
    return results;
}

void KeepWholeRounds(std::vector<CandidateResult>* results) {
    std::erase_if(*results, [](const CandidateResult& r) { return r.images.empty(); });
    if (results->empty()) return;
    size_t rounds = results->front().images.size();
    for (const CandidateResult& r : *results) rounds = std::min(rounds, r.images.size());
    for (CandidateResult& r : *results) {
        r.images.resize(rounds);
        r.records.resize(rounds);
        std::erase_if(r.stages, [&](const Stage& stage) { return size_t(stage.runs) < rounds; });
    }
}

namespace {

/// For each box the mean HDR-FLIP over its pixels and the runs, at exposures of the whole reference.
std::vector<double> FlipsOf(const std::vector<Image>& runs, const Image& reference,
                            const std::vector<Bounds2i>& boxes) {
    const auto colors = [](const Image& image) {
        return image.Part({{0, 0}, image.Resolution()}, {0, 1, 2});
    };
    const Image truth = colors(reference);
    const FlipExposures exposures = HdrFlipExposures(truth);
    std::vector<double> means(boxes.size(), 0.0);
    for (const Image& run : runs) {
        const Image map = HdrFlip(colors(run), truth, exposures);
        for (size_t b = 0; b < boxes.size(); ++b)
            for (int y = boxes[b].min.y; y < boxes[b].max.y; ++y)
                for (int x = boxes[b].min.x; x < boxes[b].max.x; ++x)
                    means[b] += double(map.Get({x, y}, 0)) / (double(boxes[b].Area()) * double(runs.size()));
    }
    return means;
}

}  // namespace

void MeasureBoxes(std::vector<CandidateResult>* results, const Reference& reference,
                  const std::vector<Bounds2i>& boxes, size_t baseline, bool isEqualTime) {
    std::vector<Runs> runs(results->size());
    std::vector<double> seconds(isEqualTime ? results->size() : 0, 0.0);
    for (size_t r = 0; r < results->size(); ++r) {
        for (const Image& image : (*results)[r].images) runs[r].push_back(&image);
        if (isEqualTime)
            for (const RunRecord& record : (*results)[r].records) seconds[r] += record.seconds;
    }
    for (size_t b = 0; b < boxes.size(); ++b) {
        const std::vector<BoxResult> measured =
            MeasureBox(boxes[b], reference, runs, baseline, Hash(b), seconds);
        for (size_t r = 0; r < results->size(); ++r) {
            (*results)[r].boxes.push_back(measured[r]);
            if (IsDenoised((*results)[r].candidate)) (*results)[r].boxes.back().bias.reset();
        }
    }
    for (CandidateResult& result : *results)
        if (result.candidate.subject == Subject::Denoisers)
            result.flips = FlipsOf(result.images, reference.image, boxes);
}

}  // namespace lacquer::compare
