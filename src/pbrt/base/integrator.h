// Light transport along camera rays.
#pragma once

#include <functional>
#include <memory>

#include "pbrt/base/bxdf.h"
#include "pbrt/base/bxdf_numbers.h"
#include "pbrt/base/camera.h"
#include "pbrt/base/interaction.h"
#include "pbrt/base/sampler.h"
#include "pbrt/core/arena.h"
#include "pbrt/core/registry.h"

namespace lacquer {

class Film;
class Observer;
class PassRecorder;
class PathGuide;
class Scene;

/// Receives the first surface that scatters along a camera ray, for auxiliary outputs.
class FirstHitObserver {
  public:
    virtual void Record(const SurfaceInteraction& si, const BxDF& bxdf, Vec3 woLocal) = 0;
    /// A medium before it absorbs or scatters this part of the light, from what the media before it let
    /// through.
    virtual void Cover(float part) = 0;

  protected:
    ~FirstHitObserver() = default;
};

/// Rays that were traced.
struct RayCounts {
    int64_t nearest = 0;  ///< to nearest hits
    int64_t shadow = 0;   ///< to whether anything is in the way; each piece between interfaces is one
};

/// What the samples of one number have in common, those of all pixels: made before the first of them, and
/// constant.
class SharedSample {
  public:
    virtual ~SharedSample() = default;
    /// Of all camera rays, in [0,1): CameraSample::time.
    virtual float Time() const = 0;
};

/// What one thread owns while it renders: scratch memory, counters, and the random numbers of stochastic
/// BxDFs.
struct ThreadState {
    Arena arena;
    Rng rng;
    BxDFDimensions dimensions;
    FirstHitObserver* firstHit = nullptr;  ///< null: nobody asks
    Film* film = nullptr;                  ///< that takes splats; null unless the integrator makes some
    PassRecorder* passes = nullptr;        ///< null: nobody asks; see film/pass_recorder.h
    const SharedSample* shared = nullptr;  ///< of the current sample; null unless the integrator shares some
    PathGuide* guide = nullptr;            ///< null: paths go by scattering alone
    int64_t cameraRays = 0;
    RayCounts rays;
    int64_t badSamples = 0;     ///< NaN, infinite or negative radiance
    int64_t pathLengthSum = 0;  ///< vertices that scattered
    BxDFCounters bxdf;

    /// What a path from the camera asks BxDFs with.
    BxDFContext Context(bool needsPdf = true) {
        return {.rng = &rng, .needsPdf = needsPdf, .counters = &bxdf, .dimensions = &dimensions};
    }
};

/// What Markov chains of a render work with: the threads of its loop.
struct ChainWork {
    /// Of the calling thread; its film takes the splats.
    std::function<ThreadState&()> state;
    /// Asked often, by any thread: the work ends as soon as it can.
    std::function<bool()> shouldStop;
    /// So many paths more are done.
    std::function<void(int64_t)> advance;
};

/// Chains of paths, each of which follows from the one before, in place of paths that belong to the samples
/// of a pixel. All their light comes as splats; a camera sample stands for one mutation. What the film gets
/// does not depend on the threads.
class MarkovChains {
  public:
    virtual ~MarkovChains() = default;
    /// Paths that are made before the first mutation.
    virtual int64_t NumStartPaths() const = 0;
    /// Makes them and starts the chains. False if it was stopped. Warns where there is no light to follow.
    virtual bool Start(const ChainWork& work, Observer& observer) = 0;
    /// Goes on to `mutations` of all chains together. How many there are then: fewer if it was stopped.
    virtual int64_t Run(int64_t mutations, const ChainWork& work) = 0;
};

/// What is not drawn, as RenderOptions has it.
struct Jitter;

/// What a SharedSample may depend on: nothing of which parts of an image are rendered, or by whom.
struct SharedSampleArgs {
    const Film& film;
    int index = 0;  ///< number of the sample
    int seed = 0;   ///< of the render
    /// False: in the middle of the range, the same for all samples.
    bool drawsWavelengths = true, drawsTime = true;
    /// State of the calling thread, for loops over threads (ParallelFor).
    std::function<ThreadState&()> state;
    std::function<bool()> isStopped;  ///< true: what is made will not be used
};

/// Radiance along a camera ray. Immutable; the scene outlives it. Paths are traced as TracedPath, which
/// counts, and records first hits.
class Integrator {
  public:
    virtual ~Integrator() = default;
    /// Incident radiance [W/(m^2 sr nm)] at the path's wavelengths; may terminate secondary wavelengths.
    virtual SampledSpectrum Li(const CameraRay& ray, SampledWavelengths& lambda, Sampler& sampler,
                               ThreadState& state) const = 0;
    /// False if it takes media for vacuum.
    virtual bool RendersMedia() const { return false; }
    /// True if it also adds light to pixels that its camera ray does not belong to: Film::AddSplat().
    virtual bool MakesSplats() const { return false; }
    /// True if MakeChains() finds its light, and Li() none. Samples then depend on those before them.
    virtual bool UsesChains() const { return false; }
    /// The chains of a render; null unless it uses some.
    /// @param film  outlives them, as the integrator does
    virtual std::unique_ptr<MarkovChains> MakeChains(const Film& /*film*/, int /*seed*/,
                                                     const Jitter& /*jitter*/) const {
        return nullptr;
    }
    /// True if the pixels' samples of one number are taken together, after ShareSample() has made what they
    /// share: they are not independent of each other, as those of one pixel are.
    virtual bool SharesSamples() const { return false; }
    /// Null unless SharesSamples().
    virtual std::unique_ptr<const SharedSample> ShareSample(const SharedSampleArgs& /*args*/) const {
        return nullptr;
    }
    /// True if it draws directions by ThreadState::guide too, and tells it what it finds while that learns.
    virtual bool UsesGuide() const { return false; }
    /// True if it tells ThreadState::passes all light that it finds.
    virtual bool TellsPasses() const { return false; }
};

struct IntegratorArgs {
    const Params& params;
    const Scene& scene;
    /// Part of a pixel that one sample stands for, for texture footprints; 0 turns filtering off.
    float footprintScale = 1;
    Observer* observer = nullptr;  ///< for warnings; may be null
    /// False: one that cannot render the scene is an error (SceneError) rather than replaced by another.
    bool mayBeReplaced = true;
};
struct IntegratorKind {
    static constexpr const char* kKind = "integrator";
    using Factory = std::unique_ptr<Integrator> (*)(const IntegratorArgs&);
    /// What its images lack of those that "volpath" converges to.
    struct Traits {
        /// Why it makes another image altogether, as the end of a sentence that its name begins; null: it
        /// does not.
        const char* otherImage = nullptr;
        /// Light that it finds in no scene that has it; null: none.
        const char* neverFinds = nullptr;
        bool findsDeltaLights = true;      ///< point-like and distant ones
        bool rendersSubsurface = false;    ///< light that scatters below surfaces
        bool shadowsOfInterfaces = false;  ///< surfaces of material "interface" cast shadows
        bool takesLightSampler = false;    ///< `"string lightsampler"`
        bool makesSplats = false;          ///< as Integrator::MakesSplats()
        /// Reads the samples per pixel, which are mutations of Integrator::MakeChains(); null: the sampler
        /// says how many there are.
        int (*mutationsPerPixel)(const Params&) = nullptr;
    };
};

}  // namespace lacquer
