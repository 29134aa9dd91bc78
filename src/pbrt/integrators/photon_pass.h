// The photons of one iteration of photon mapping.
#pragma once

#include "pbrt/integrators/photon_map.h"
#include "pbrt/integrators/spectral_mis.h"
#include "pbrt/integrators/subpath.h"
#include "pbrt/samplers/low_discrepancy.h"

namespace lacquer {

/// What the samples of an iteration share: photons are of use to paths of their own wavelengths and time
/// only.
class PhotonPass final : public SharedSample {
  public:
    PhotonPass(PhotonMap map, const SampledWavelengths& lambda, float time)
        : map_(std::move(map)), lambda_(lambda), time_(time) {}
    float Time() const override { return time_; }
    const PhotonMap& Map() const { return map_; }
    const SampledWavelengths& Wavelengths() const { return lambda_; }

  private:
    PhotonMap map_;
    SampledWavelengths lambda_;
    float time_;
};

/// Radius of an iteration, counted from 0, over that of the first. Of the i-th and the next one, counted from
/// 1, the squares are as (i + 1) to (i + alpha) [Knaus and Zwicker 2011]: the variance of the mean then falls
/// as 1 / iterations^alpha, its bias as 1 / iterations^(1 - alpha).
float RadiusScale(int iteration);
inline constexpr double kRadiusAlpha = 2. / 3;

/// Traces photons. Immutable.
class PhotonTracer {
  public:
    /// Reads "photonsperiteration", "radius" and "seed".
    /// @param maxDepth  scattering events of a path after which it ends
    PhotonTracer(const IntegratorArgs& args, int maxDepth);
    /// The photons of iteration args.index. Errors: SceneError if they take too much memory.
    std::unique_ptr<const PhotonPass> Trace(const SharedSampleArgs& args) const;

  private:
    struct Iteration;
    void TracePath(const Iteration& it, int64_t number, Sampler& numbers, ThreadState& state,
                   std::vector<Photon>* photons) const;

    const Scene& scene_;
    FileLoc loc_;
    int maxDepth_;
    int64_t count_;
    float radius_;
    std::optional<int> seed_;  ///< empty: the render's
    PathSurroundings surroundings_;
    EmitterTable emitters_;
};

}  // namespace lacquer
