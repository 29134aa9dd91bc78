// Several renders of one scene by several estimators, in turn, with equal time or equal samples.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "compare/box_statistics.h"
#include "compare/candidate.h"
#include "compare/reference.h"
#include "compare/variation.h"
#include "pbrt/base/film.h"
#include "pbrt/core/progress.h"
#include "pbrt/image/texture_memory.h"
#include "pbrt/scene/description.h"

namespace lacquer::compare {

/// What every run may spend: seconds of rendering (without loading) or samples in each pixel.
struct Budget {
    std::optional<double> seconds;
    int samplesPerPixel = 0;  ///< where there is no time
};

/// Where the reference comes from.
struct ReferencePlan {
    std::string file;     ///< an image; empty: rendered
    Candidate candidate;  ///< that renders it
    Budget budget;        ///< of all parts together
};

struct ExperimentPlan {
    SceneDescription scene;
    std::vector<Candidate> candidates;
    size_t baseline = 0;
    Budget budget;
    int runs = 4;
    int seed = 0;  ///< the first of the runs' own seeds
    FilmOverrides film;
    TextureMemory textures;
    ReferencePlan reference;
    /// As TimeDenoisers() has it; of the time of a run, so much is for denoising. Empty: none.
    std::vector<double> denoiseSeconds;
};

/// Seed, count and cost of one finished render.
struct RunRecord {
    int seed = 0;
    double samplesPerPixel = 0;  ///< mean over the pixels
    int minSamples = 0, maxSamples = 0;
    double seconds = 0;         ///< of rendering and denoising
    double denoiseSeconds = 0;  ///< of them
    double loadSeconds = 0;     ///< of building the scene before it; not part of the budget
    int64_t badSamples = 0;
};

/// Squared errors at an early stage of the runs: when every pixel had `samples`.
struct Stage {
    int samples = 0;
    int runs = 0;                ///< that got there
    double seconds = 0;          ///< summed over them
    std::vector<float> squares;  ///< of each pixel, summed over them
};

/// Everything that one candidate gave.
struct CandidateResult {
    Candidate candidate;
    std::vector<RunRecord> records;
    std::vector<Image> images;  ///< of the runs: R, G, B, samples
    std::vector<Stage> stages;  ///< at 1, 2, 4, ... samples; none of candidates that denoise
    std::vector<BoxResult> boxes;
    std::vector<double> flips;  ///< of denoisers: for each box the mean HDR-FLIP of the runs
};

/// One render: R, G, B, samples.
struct RenderedRun {
    Image image;
    RunRecord record;
    bool interrupted = false;
};

/// Renders candidates one after another, run by run, so that a machine that slows down hits all alike; the
/// order changes from run to run. Each render has a seed of its own, also across candidates: all are
/// independent. Samplers keep their kind but get that seed and are randomised. Memory: 12 bytes for each
/// pixel, candidate and run, and 4 for each pixel, candidate and stage.
class Experiment {
  public:
    /// Parts of a rendered reference, from whose differences its noise is known.
    static constexpr int kReferenceParts = 8;

    /// @param plan  its scene is copied for each render
    /// Errors: SceneErrors of the scene, when it is first built.
    Experiment(const ExperimentPlan& plan, Observer& observer)
        : plan_(plan), observer_(observer), denoiseSeconds_(plan.denoiseSeconds) {}

    /// Renders the reference in parts. Empty if stopped before two of them were done; with fewer parts than
    /// asked for (and so fewer samples) if stopped later.
    std::optional<Reference> RenderReference();

    /// What denoising takes each candidate, measured with a render of few samples; for the plan. Empty where
    /// nobody denoises. Errors: OverrideError if too little of the time of a run is left.
    std::vector<double> TimeDenoisers() const;

    /// Renders all runs of all candidates, or as many as there are before a stop.
    std::vector<CandidateResult> Run(const Reference& reference);

    /// Full size of the image, and the part of it that is rendered.
    struct Frame {
        Int2 resolution;
        Bounds2i pixels;
        const ColorSpace* colorSpace = nullptr;
    };
    /// The scene, built once to see it: with the baseline if that is an estimator, else as it is.
    RenderSetup BuildOnce() const;
    static Frame FrameOf(const RenderSetup& setup);

  private:
    /// A candidate's budget without the time for denoising.
    Budget BudgetOf(size_t candidate) const;
    RenderedRun Render(const Candidate& candidate, const Budget& budget, int seed, const std::string& name,
                       const std::function<void(const Image&, int, double)>& atStage) const;

    const ExperimentPlan& plan_;
    Observer& observer_;
    std::vector<double> denoiseSeconds_;  ///< the plan's, then of each candidate's last image
};

/// Squared errors of unfinished rounds do not count: cuts all candidates to the number of runs that each has,
/// or, where the first round is unfinished, drops the candidates that have none.
void KeepWholeRounds(std::vector<CandidateResult>* results);

/// Fills `boxes` of all results, and `flips` of denoisers. Of candidates that denoise there is no check of
/// the mean for bias, which says nothing about theirs. @param baseline  index among the plan's candidates
/// @param isEqualTime  ratios are those at equal time, from what the runs took; false: as the images are
void MeasureBoxes(std::vector<CandidateResult>* results, const Reference& reference,
                  const std::vector<Bounds2i>& boxes, size_t baseline, bool isEqualTime);

}  // namespace lacquer::compare
