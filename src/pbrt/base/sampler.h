// Sample points: numbers that depend on (seed, pixel, sample index, dimension) and on nothing else.
#pragma once

#include <memory>
#include <optional>

#include "pbrt/core/params.h"
#include "pbrt/core/registry.h"
#include "pbrt/core/rng.h"

namespace lacquer {

/// A set of points beside a sampler's own dimensions, for a part of a path whose numbers nobody counts.
struct PointSet {
    uint64_t key = 0;     ///< which one; sets of different keys are independent
    uint32_t copy = 0;    ///< which of the points that a sample of the pixel has in the set
    uint32_t copies = 1;  ///< how many of them
};

/// A source of sample points of one thread. Clone() gives another thread its own.
class Sampler {
  public:
    virtual ~Sampler() = default;
    virtual int SamplesPerPixel() const = 0;
    /// The least count above `samples` at which to stop: the first so many samples of a pixel are about as
    /// well distributed as this sampler's can be. With a count between, errors may be larger than with fewer
    /// samples. The default, of samplers that prefer none, is the next number.
    virtual int NextGoodCount(int samples) const { return samples + 1; }
    /// Positions at the first dimension of a sample. Calls for one pixel usually come with rising `index`.
    virtual void StartPixelSample(Int2 pixel, int index) = 0;
    /// The next one or two dimensions, in [0,1).
    virtual float Get1D() = 0;
    virtual Point2 Get2D() = 0;
    /// Past the same dimensions without a value, for which nothing need be computed.
    virtual void Skip1D() { Get1D(); }
    virtual void Skip2D() { Get2D(); }
    /// The two dimensions for the position in the pixel; called first, once a sample.
    virtual Point2 GetPixel2D() { return Get2D(); }
    /// The point of the current sample in a set: uniform, and stratified in all its dimensions together with
    /// those of the pixel's other samples. Takes no dimension of the sampler. False (default): this sampler
    /// knows no such points.
    virtual bool GetPoint(const PointSet&, LeadingNumbers::Block*) const { return false; }
    virtual std::unique_ptr<Sampler> Clone() const = 0;
};

struct SamplerArgs {
    const Params& params;
    Int2 resolution;                     ///< of the full image
    std::optional<int> samplesPerPixel;  ///< overrides the scene's
    int seed = 0;                        ///< where the scene gives none
    class Observer* observer = nullptr;  ///< for warnings; may be null
};
struct SamplerKind {
    static constexpr const char* kKind = "sampler";
    using Factory = std::unique_ptr<Sampler> (*)(const SamplerArgs&);
};

}  // namespace lacquer
