#include "compare/experiment.h"

#include <algorithm>
#include <bit>
#include <chrono>

#include "pbrt/core/check.h"
#include "pbrt/core/rng.h"
#include "pbrt/integrators/render.h"
#include "pbrt/scene/builder.h"

namespace lacquer::compare {

namespace {

/// More samples per pixel than time limits reach.
constexpr int kUnlimitedSamples = 1 << 16;
/// Textures are filtered alike in all renders, however many samples they take: as for the reference.
constexpr int kFilterSamples = 64;
/// Seeds of the reference's parts are this far from those of the runs.
constexpr int kReferenceSeeds = 1 << 20;

using Clock = std::chrono::steady_clock;

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

BuildOptions OptionsOf(const ExperimentPlan& plan, const Candidate& candidate, const Budget& budget) {
    BuildOptions options;
    options.film = plan.film;
    options.textures = plan.textures;
    options.materials = OverridesOf(candidate);
    options.samplesPerPixel = budget.seconds ? kUnlimitedSamples : budget.samplesPerPixel;
    options.filterSamples = kFilterSamples;
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
    run.record.loadSeconds = std::chrono::duration<double>(Clock::now() - start).count();
    RenderOptions options;
    options.endSample = setup.sampler->SamplesPerPixel();
    options.seed = seed;
    if (budget.seconds) {
        options.timeLimit = *budget.seconds;
        options.stopsAtGoodCounts = true;
    }
    options.pixelJitter = !setup.options.disablePixelJitter;
    options.wavelengthJitter = !setup.options.disableWavelengthJitter;
    options.afterPass = [&](int samples, double seconds) {
        if (atStage && std::has_single_bit(unsigned(samples)))
            atStage(*setup.film->Develop(), samples, seconds);
    };
    const RenderStats stats =
        lacquer::Render(*setup.scene, *setup.integrator, *setup.sampler, *setup.film, options, observer);
    const std::vector<int> counts = setup.film->SampleCounts();
    run.image = setup.film->Develop()->WithChannel("samples", {counts.begin(), counts.end()});
    LACQUER_CHECK(run.image.HasRGB());
    run.interrupted = stats.interrupted;
    run.record.seed = seed;
    run.record.samplesPerPixel = double(stats.samples) / double(setup.film->PixelBounds().Area());
    run.record.minSamples = stats.samplesPerPixel;
    run.record.maxSamples = stats.maxSamples;
    run.record.seconds = stats.seconds;
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

std::vector<CandidateResult> Experiment::Run(const Reference& reference) {
    std::vector<CandidateResult> results;
    for (const Candidate& candidate : plan_.candidates) results.push_back({candidate, {}, {}, {}, {}});
    const size_t count = results.size();
    for (int run = 0; run < plan_.runs; ++run)
        for (size_t i = 0; i < count; ++i) {
            CandidateResult& result = results[(i + size_t(run)) % count];
            const std::string name = "Run " + std::to_string(run + 1) + " of " + std::to_string(plan_.runs) +
                                     ", " + result.candidate.Label();
            // Stages of an interrupted run do not count: they wait here until it is whole.
            std::vector<Stage> stages = result.stages;
            const int seed = plan_.seed + 1 + run * int(count) + int(&result - results.data());
            RenderedRun rendered = Render(result.candidate, plan_.budget, seed, name,
                                          [&](const Image& image, int samples, double seconds) {
                                              AddStage(&stages, reference, image, samples, seconds);
                                          });
            if (rendered.interrupted) return results;
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
        for (size_t r = 0; r < results->size(); ++r) (*results)[r].boxes.push_back(measured[r]);
    }
}

}  // namespace lacquer::compare
