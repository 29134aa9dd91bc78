// Emitters, and ways to choose among them.
#pragma once

#include <memory>
#include <optional>
#include <span>

#include "pbrt/base/interaction.h"
#include "pbrt/base/texture.h"
#include "pbrt/core/sampled_spectrum.h"

namespace lacquer {

class Shape;

/// Light that arrives at a reference point along one direction, with visibility still to be tested.
struct LightSample {
    SampledSpectrum L;  ///< radiance [W/(m^2 sr nm)]; for delta lights, such that L / pdf is right with pdf 1
    Vec3 wi{0, 0, 1};   ///< unit, toward the light
    float pdf = 0;      ///< [1/sr]; 1 for delta lights
    Point3 p{0};        ///< point on the light; for infinite lights outside the scene
    float pError = 0;
    Normal3 n{0};  ///< normal at p, zero where there is none
};

/// Light as it leaves its source along a ray: L |n . w| / (pdfPosition pdfDirection) estimates the flux,
/// without the cosine where n is zero.
struct LightEmission {
    SampledSpectrum L;  ///< radiance; intensity of lights at a point; irradiance of those in one direction
    Vec3 w{0, 0, 1};    ///< unit, along the light
    Point3 p{0};        ///< on the light; for infinite and distant lights outside the scene
    float pError = 0;
    Normal3 n{0};  ///< geometric normal at p, zero where there is none
    Point2 uv{0};
    float pdfPosition = 0;   ///< as in EmissionDensity
    float pdfDirection = 0;  ///< as in EmissionDensity
};
/// Density of light that leaves a source.
struct EmissionDensity {
    float position = 0;   ///< [1/m^2], over the light, or for infinite and distant lights over a plane across
                          ///< w; 1 for lights at a point
    float direction = 0;  ///< [1/sr]; 1 for lights in one direction
};

/// Power and extent of a light, for choosing among many [Conty Estevez and Kulla 2018].
struct LightBounds {
    Bounds3 bounds;
    Vec3 axis{0, 0, 1};    ///< central direction of emission
    float power = 0;       ///< luminous flux, in arbitrary but common units
    float cosTheta_o = 1;  ///< spread of normals about the axis
    float cosTheta_e = 0;  ///< emission beyond the normals
    bool twoSided = false;
};

/// A light source. Immutable and thread-safe after Preprocess().
class Light {
  public:
    enum class Kind { DeltaPosition, DeltaDirection, Area, Infinite };

    explicit Light(Kind kind) : kind_(kind) {}
    virtual ~Light() = default;
    Kind GetKind() const { return kind_; }
    bool IsDelta() const { return kind_ == Kind::DeltaPosition || kind_ == Kind::DeltaDirection; }
    bool IsInfinite() const { return kind_ == Kind::Infinite; }

    /// Called once with the bounds of everything that rays can hit, before rendering.
    virtual void Preprocess(const Bounds3& /*sceneBounds*/) {}
    /// Draws a direction toward the light as seen from `ref`. Empty if none can contribute.
    virtual std::optional<LightSample> SampleLi(const LightReference& ref, Point2 u,
                                                const SampledWavelengths& lambda) const = 0;
    /// Density over solid angle with which SampleLi draws `wi`; 0 for delta lights. For area lights `hit` is
    /// the point of the light that a ray from `ref` along `wi` meets; unused otherwise.
    virtual float PdfLi(const LightReference& ref, Vec3 wi, const SurfaceInteraction* hit) const = 0;
    /// Draws a ray along which the light emits. Where infinite lights shine on a part of the scene only
    /// (through a portal), Le() at the first hit tells whether it is lit. Empty if the draw fails.
    virtual std::optional<LightEmission> SampleLe(Point2 /*uPosition*/, Point2 /*uDirection*/,
                                                  const SampledWavelengths& /*lambda*/) const {
        return std::nullopt;
    }
    /// Density with which SampleLe draws a ray along w from a point with normal n (of area lights). Deltas
    /// count as 1. For scaled quadrics the position's density is that of the unscaled ones: a weight, not a
    /// divisor.
    virtual EmissionDensity PdfLe(Normal3 /*n*/, Vec3 /*w*/) const { return {}; }
    /// Area lights: radiance that leaves a point of the light toward w. Others: 0.
    virtual SampledSpectrum L(Point3 /*p*/, Normal3 /*n*/, Point2 /*uv*/, Vec3 /*w*/,
                              const SampledWavelengths& /*lambda*/) const {
        return SampledSpectrum(0);
    }
    /// Infinite lights: radiance that arrives along a ray that leaves the scene. Others: 0.
    virtual SampledSpectrum Le(const Ray& /*ray*/, const SampledWavelengths& /*lambda*/) const {
        return SampledSpectrum(0);
    }
    /// True for an infinite light of the same radiance everywhere: it is found by scattered rays alone.
    virtual bool IsUniformInfinite() const { return false; }
    /// Light group: an index in SceneParts::lightGroups; 0: none.
    int Group() const { return group_; }
    void SetGroup(int group) { group_ = group; }
    /// True for the light of a shape whose material is a holdout: the camera does not see it.
    bool IsHoldout() const { return isHoldout_; }
    void SetHoldout(bool isHoldout) { isHoldout_ = isHoldout; }
    /// Total luminous power (any common unit), for choosing lights.
    virtual float Power() const = 0;
    /// Extent of a light that has one; empty for infinite and distant lights.
    virtual std::optional<LightBounds> Bounds() const { return std::nullopt; }

  private:
    Kind kind_;
    int group_ = 0;
    bool isHoldout_ = false;
};

/// A light and the probability with which it was chosen.
struct SampledLight {
    const Light* light = nullptr;
    float p = 0;
};

/// Chooses a light to sample.
class LightSampler {
  public:
    virtual ~LightSampler() = default;
    /// Draws a light for a reference point, u in [0,1). Empty if there is none worth sampling.
    virtual std::optional<SampledLight> Sample(const LightReference& ref, float u) const = 0;
    /// Probability with which Sample() draws `light`.
    virtual float Pmf(const LightReference& ref, const Light* light) const = 0;
};

/// What a light's factory gets: CTM is light to world.
struct LightArgs {
    const Params& params;
    Transform renderFromLight;
    Transform renderFromWorld;  ///< for parameters given in world space (portals)
    TextureLibrary& textures;
    class Observer* observer = nullptr;  ///< for warnings; may be null
};
struct LightKind {
    static constexpr const char* kKind = "light";
    using Factory = std::unique_ptr<Light> (*)(const LightArgs&);
};
/// An area light for each primitive of a shape. CTM is the shape's.
struct AreaLightArgs {
    const Params& params;
    Transform renderFromLight;
    const Shape& shape;
    const FloatTexture* alpha;  ///< the shape's, or null
    TextureLibrary& textures;
};
struct AreaLightKind {
    static constexpr const char* kKind = "area light";
    using Factory = std::vector<std::unique_ptr<Light>> (*)(const AreaLightArgs&);
};
struct LightSamplerKind {
    static constexpr const char* kKind = "light sampler";
    using Factory = std::unique_ptr<LightSampler> (*)(std::span<const Light* const>);
};

/// What an emission spectrum is multiplied by so that its luminance, or its white's for rgb, becomes `scale`:
/// scale / integral of y(lambda) S0(lambda), S0 being the spectrum itself or the colour space's white for
/// rgb.
float EmissionScale(const Spectrum& emission, const Params& params, std::string_view parameter, float scale);
/// Luminance of an emission of magnitude EmissionScale() with unit `scale`: 1, or that of the rgb triple.
float EmissionLuminance(const Params& params, std::string_view parameter);

}  // namespace lacquer
