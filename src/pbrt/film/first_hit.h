// What the camera sees first along a ray, beside radiance.
#pragma once

#include <optional>

#include "pbrt/base/film.h"
#include "pbrt/base/integrator.h"

namespace lacquer {

/// One sample's first surface that scatters (interface surfaces are passed), in rendering space.
struct FirstHit {
    bool hit = false;
    float coverage = 0;  ///< part of the light from behind that media before the hit keep away
    Point3 p{0};
    Normal3 n{0}, ns{0};  ///< geometric and shading, facing the viewer
    Point2 uv{0};
    float time = 0;
    int instance = -1;  ///< as SurfaceInteraction has it
    /// While the shutter is open, right and up [pixels]; where nothing is hit, of what is infinitely far.
    std::optional<Vec2> motion;
    /// Part of the light along wo that is scattered, reflected or transmitted: in [0,1] in the mean.
    SampledSpectrum albedo;
    Vec3 dpdx{0}, dpdy{0};               ///< change of p to the next pixel, to the right and downward
    int object = -1;                     ///< index in SceneNames::objects
    const Material* material = nullptr;  ///< the shape's: a mixture, not what it drew
};

/// Keeps the last first hit that an integrator reported; one for each thread.
class FirstHitRecorder final : public FirstHitObserver {
  public:
    explicit FirstHitRecorder(bool wantAlbedo) : wantAlbedo_(wantAlbedo) {}
    void Record(const SurfaceInteraction& si, const BxDF& bxdf, Vec3 woLocal) override;
    void Cover(float part) override { last_.coverage += (1 - last_.coverage) * part; }
    /// Forgets the last hit.
    /// @param seed   of the pixel: the albedos of its samples are parts of one sequence of points
    /// @param index  of the sample
    void Start(uint64_t seed, int index) {
        last_ = {};
        seed_ = seed;
        index_ = index;
    }
    const FirstHit& Last() const { return last_; }
    FirstHit& Last() { return last_; }

  private:
    bool wantAlbedo_;
    uint64_t seed_ = 0;
    int index_ = 0;
    FirstHit last_;
};

/// Directional albedo of a BxDF for light along `wo`: an unbiased estimate from `count` of its samples, whose
/// numbers are the points first, first + 1, ... of a sequence shifted by `seed`. Specular lobes count like
/// others.
///
/// It is the fraction of energy that the surface does not absorb, so it scatters as importance does: radiance
/// would carry the 1/eta^2 of refraction, by which clear glass of index 1.5 gets 0.47 from outside and more
/// than 2 from inside.
SampledSpectrum DirectionalAlbedo(const BxDF& bxdf, Vec3 wo, uint64_t seed, int first, int count);

}  // namespace lacquer
