// The loop over tiles, pixels and samples that all integrators share.
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "pbrt/base/film.h"
#include "pbrt/base/integrator.h"
#include "pbrt/core/progress.h"
#include "pbrt/film/aov.h"
#include "pbrt/film/passes.h"
#include "pbrt/integrators/film_sample.h"
#include "pbrt/integrators/pixel_stats.h"
#include "pbrt/integrators/sample_shares.h"
#include "pbrt/scene/scene.h"

namespace lacquer {

struct RenderOptions {
    int firstSample = 0;  ///< the samples [firstSample, endSample) of each pixel
    int endSample = 0;
    /// Samples of a pixel in the whole image, of which these are a part or which they may exceed when more
    /// were asked for later: what is learned from samples depends on it. 0: endSample.
    int plannedSamples = 0;
    /// The film has some of them already: the first Film::SampleCount() of each pixel, counted from
    /// firstSample.
    bool resumes = false;
    int seed = 0;
    Jitter jitter;
    /// [s], of rendering itself: afterPass does not count. One sample in every pixel is taken in any case.
    double timeLimit = std::numeric_limits<double>::infinity();
    /// Under a time limit and below kFreeCounts samples, stop at counts that the sampler calls good: all
    /// pixels get as many, and the time is up to that of the next good count shorter.
    bool stopsAtGoodCounts = false;
    /// For tests: false uses a guide without asking whether it is worth its time.
    bool triesGuide = true;
    /// Adaptive sampling: of the samples above, which are then those of a pixel on average, each pixel of the
    /// film takes its share. Null: all pixels take all.
    const SampleShares* shares = nullptr;
    /// Stop when NoiseLevel() of the film, which keeps halves, has come down to this; 0: never. It is looked
    /// at after few counts of samples, the same in every run.
    double noiseTarget = 0;
    /// Block of the halves (Halves::block); 0: the best one for the samples of this render.
    int halfBlock = 0;
    /// All samples of a pixel one after another, in tiles of this side: for a part of a render that nobody
    /// looks at before its end. 0: in passes.
    int tileOfOnePass = 0;
    AovBuffer* aovs = nullptr;  ///< null: none
    /// Null: none. Else the film keeps its passes (Film::KeepPasses), and the integrator TellsPasses().
    const PassSet* passes = nullptr;
    PixelStats* pixelStats = nullptr;  ///< of the film's pixels; null: nobody asks
    /// Called between passes, when the film is consistent, with the number of samples that every pixel has
    /// and the seconds of rendering so far.
    std::function<void(int samples, double seconds)> afterPass;
    /// Called every `checkpointInterval` seconds, amid a pass as well, while no thread adds samples.
    std::function<void(double seconds)> checkpoint;
    double checkpointInterval = std::numeric_limits<double>::infinity();
    /// The interval becomes longer where a checkpoint takes more than this part of it.
    double checkpointShare = 1;
};

/// Block of the halves for a render of so many samples. @param isUneven  pixels get different numbers of
/// samples: down to an eighth of them
int BestHalfBlock(int samples, bool isUneven = false);
/// That of a render with a noise target, however many samples it may take.
constexpr int kNoiseHalfBlock = 4;
/// The fewest samples of a pixel after which a noise target is looked at.
int FirstNoiseCount(bool hasShares);

/// Samples that all pixels of a film have, and that some have: of the samples from `first` on that a pixel
/// has on average, with shares.
struct SampleSpan {
    int least = 0, most = 0;
};
/// @param taken  by each pixel, rows from the top; not empty
/// @param shares  null: all are alike
SampleSpan SampleSpanOf(const std::vector<int>& taken, const Bounds2i& pixels, const SampleShares* shares,
                        int first);

/// From so many samples on, a few more than a good count hardly matter.
constexpr int kFreeCounts = 64;

/// Counters of a render, summed over its threads.
struct RenderStats {
    double seconds = 0;       ///< without afterPass
    int samplesPerPixel = 0;  ///< that every pixel has got; with shares, of which every pixel has got its own
    int maxSamples = 0;       ///< the same of some pixels only, where a limit or a stop came within a pass
    int64_t samples = 0;  ///< of all pixels, those for which the camera has no ray and resumed ones included
    int64_t cameraRays = 0, raysTraced = 0, shadowRays = 0, badSamples = 0, pathLengthSum = 0;
    BxDFCounters bxdf;
    int threads = 0;
    std::optional<double> noise;  ///< NoiseLevel() where it was looked at last,
    int noiseSamples = 0;         ///< and after how many samples
    bool reachedNoise = false;    ///< it has come down to the target
    bool timedOut = false;        ///< the time limit came first
    bool interrupted = false;     ///< the observer asked to stop
    bool wasGuided = false;       ///< a guide was worth its time
};

/// Renders in passes of growing length (to 8, 32, 96 samples, then 64 more each time), so that a stop at any
/// time leaves a whole image. The film does not depend on passes, tiles or threads.
///
/// Under a time limit passes double instead (1, 2, 4, ..., 64, then 64 more each), so that renders of
/// different speed meet at the same counts, and shorten before the limit. The limit then falls into a short
/// pass, whose tiles are spread over the image: some pixels get its samples, the others do not. Whether a
/// pixel does is settled before its samples are taken, by the time that everything before them took, and not
/// by their values: every pixel stays unbiased.
RenderStats Render(const Scene& scene, const Integrator& integrator, const Sampler& sampler, Film& film,
                   const RenderOptions& options, Observer& observer);

}  // namespace lacquer
