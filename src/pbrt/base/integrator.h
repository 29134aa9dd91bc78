// Light transport along camera rays.
#pragma once

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

/// What one thread owns while it renders: scratch memory, counters, and the random numbers of stochastic
/// BxDFs.
struct ThreadState {
    Arena arena;
    Rng rng;
    BxDFDimensions dimensions;
    FirstHitObserver* firstHit = nullptr;  ///< null: nobody asks
    Film* film = nullptr;                  ///< that takes splats; null unless the integrator makes some
    PassRecorder* passes = nullptr;        ///< null: nobody asks; see film/pass_recorder.h
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
    };
};

}  // namespace lacquer
