// Participating media: what light meets between surfaces.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "pbrt/base/phase_function.h"
#include "pbrt/core/params.h"
#include "pbrt/core/registry.h"
#include "pbrt/core/sampled_spectrum.h"
#include "pbrt/core/transform.h"

namespace lacquer {

/// What a medium does to light at one point.
struct MediumProperties {
    SampledSpectrum sigma_a{0.f}, sigma_s{0.f};  ///< absorbed and scattered [1 / unit of length]
    SampledSpectrum Le{
        0.f};  ///< emitted radiance: a path through the point gains sigma_a Le per unit of length

    SampledSpectrum SigmaT() const { return sigma_a + sigma_s; }
    /// What light along a direction with these factors meets.
    void Scale(const DirectionalFactors& along) {
        sigma_a *= along.extinction;
        sigma_s *= along.extinction;
        sigma_a += sigma_s * (1 - along.albedo);
        sigma_s *= along.albedo;
    }
};

/// Part of a ray with an upper bound on sigma_t = sigma_a + sigma_s.
struct MajorantSegment {
    float tMin = 0, tMax = 0;
    SampledSpectrum sigmaMaj{0.f};  ///< [1 / unit of length]
};

/// Upper bounds of a density in the cells of a box.
class MajorantGrid {
  public:
    /// @param resolution  cells along each axis, at least 1
    MajorantGrid(const Bounds3& bounds, Int3 resolution)
        : bounds_(bounds),
          resolution_(resolution),
          maxima_(size_t(resolution.x) * size_t(resolution.y) * size_t(resolution.z), 0.f) {}

    const Bounds3& Bounds() const { return bounds_; }
    Int3 Resolution() const { return resolution_; }
    float At(Int3 cell) const { return maxima_[Index(cell)]; }
    void Set(Int3 cell, float bound) { maxima_[Index(cell)] = bound; }
    /// The part of the box that a cell covers.
    Bounds3 CellBounds(Int3 cell) const;

  private:
    size_t Index(Int3 c) const {
        return (size_t(c.z) * size_t(resolution_.y) + size_t(c.y)) * size_t(resolution_.x) + size_t(c.x);
    }
    Bounds3 bounds_;
    Int3 resolution_;
    std::vector<float> maxima_;
};

/// The segments of a ray inside a medium, in order; parts that are left out are empty. A value: no heap.
class MajorantWalk {
  public:
    /// Nothing.
    MajorantWalk() = default;
    /// One segment.
    MajorantWalk(float tMin, float tMax, SampledSpectrum sigmaMaj)
        : sigma_(sigmaMaj), t_(tMin), tMax_(tMax), single_(true) {}
    /// The cells of a grid that the ray crosses between 0 and tMax, each with sigma times its bound; empty
    /// cells are left out. [Amanatides and Woo 1987]
    /// @param ray  in the space of the grid's box, not normalised: t counts as on the ray in rendering space
    MajorantWalk(const MajorantGrid& grid, const Ray& ray, float tMax, SampledSpectrum sigma);

    /// False at the end.
    bool Next(MajorantSegment* segment);

  private:
    float Crossing(int axis) const;

    SampledSpectrum sigma_{0.f};
    float t_ = 0, tMax_ = -1;
    bool single_ = false;
    const MajorantGrid* grid_ = nullptr;
    Int3 cell_{0}, step_{0};
    Vec3 firstPlane_{0};     ///< t at the lower face of the box
    Vec3 planeDistance_{0};  ///< t from one wall of cells to the next, negative where the ray goes down
    Vec3 nextCrossing_{0};   ///< t at which the ray leaves its cell, for each axis
};

/// The phase function of a medium, made once; where it depends on the wavelength, anew for each path.
class MediumPhase {
  public:
    /// @param renderFromMedium  turns orientations as it turns vectors
    MediumPhase(std::unique_ptr<const PhaseModel> model, const Transform& renderFromMedium);

    const PhaseModel& Model() const { return *model_; }
    /// In `arena` or in this object.
    const PhaseFunction& At(const SampledWavelengths& lambda, Arena& arena) const {
        return isChromatic_ ? *model_->Make({frame_, lambda}, arena) : *fixed_;
    }
    bool IsDirectional() const { return isDirectional_; }
    DirectionalFactors FactorsAlong(Vec3 w, const SampledWavelengths& lambda) const {
        return isDirectional_ ? fixed_->FactorsAlong(w, lambda) : DirectionalFactors();
    }

  private:
    std::unique_ptr<const PhaseModel> model_;
    Frame frame_;  ///< of the medium
    std::unique_ptr<Arena> arena_;
    const PhaseFunction* fixed_;
    bool isChromatic_, isDirectional_;
};

/// A medium. Immutable and thread-safe. Points and rays are in rendering space, whose unit of length is the
/// world's.
///
/// Where the phase function has a directional extinction or albedo (flakes, oriented ensembles), At() and
/// Majorants() count in units of it: light along w meets FactorsAlong(w) times that. Along a ray these are
/// the same everywhere, and whoever follows it multiplies by them (Along(), TrackCollisions());
/// implementations have nothing to do with it.
class Medium {
  public:
    explicit Medium(MediumPhase phase) : phase_(std::move(phase)) {}
    virtual ~Medium() = default;
    virtual MediumProperties At(Point3 p, const SampledWavelengths& lambda) const = 0;
    /// Bounds along a ray (unit direction) between 0 and tMax. At no point of a segment may sigma_t exceed
    /// its bound by more than rounding; outside of all segments sigma_t is 0.
    virtual MajorantWalk Majorants(const Ray& ray, float tMax, const SampledWavelengths& lambda) const = 0;
    /// The same in all of the medium; in `arena` or in this object.
    const PhaseFunction& Phase(const SampledWavelengths& lambda, Arena& arena) const {
        return phase_.At(lambda, arena);
    }
    /// True if FactorsAlong() are not 1 everywhere.
    bool IsDirectional() const { return phase_.IsDirectional(); }
    /// Extinction and albedo along w (unit) over those of At(): those of the phase function.
    DirectionalFactors FactorsAlong(Vec3 w, const SampledWavelengths& lambda) const {
        return phase_.FactorsAlong(w, lambda);
    }
    /// What light along a ray (unit direction) meets at its origin.
    MediumProperties Along(const Ray& ray, const SampledWavelengths& lambda) const {
        MediumProperties properties = At(ray.o, lambda);
        if (IsDirectional()) properties.Scale(FactorsAlong(ray.d, lambda));
        return properties;
    }
    /// For mixtures.
    const PhaseModel& GetPhaseModel() const { return phase_.Model(); }
    /// Light group of the emission: an index in SceneParts::lightGroups; 0: none.
    int Group() const { return group_; }
    void SetGroup(int group) { group_ = group; }
    /// True if At() may give emission.
    virtual bool IsEmissive() const = 0;
    /// True if At() is the same everywhere; then Majorants() is one segment with the exact sigma_t.
    virtual bool IsHomogeneous() const { return false; }
    /// Bytes of grids and tables.
    virtual size_t MemoryBytes() const { return 0; }

  private:
    MediumPhase phase_;
    int group_ = 0;
};

/// Media by their names; null for one that could not be made.
using NamedMedia = std::map<std::string, const Medium*>;

/// What a medium's factory gets: CTM is medium to world. `named` holds the media that were made before this
/// one; null: none.
struct MediumArgs {
    const Params& params;
    Transform renderFromMedium;
    const NamedMedia* named = nullptr;
};
struct MediumKind {
    static constexpr const char* kKind = "medium";
    using Factory = std::unique_ptr<Medium> (*)(const MediumArgs&);
};

}  // namespace lacquer
