// From textures to scattering: what a surface is made of.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "pbrt/base/bssrdf.h"
#include "pbrt/base/bxdf.h"
#include "pbrt/base/texture.h"
#include "pbrt/core/arena.h"
#include "pbrt/core/registry.h"

namespace lacquer {

/// Indices of refraction on the two sides of an interface in a stack, relative to the vacuum.
struct InterfaceMedia {
    float etaAbove = 1;
    std::optional<float> etaBelow;  ///< empty: the material itself says it, or it is the same as above
};

/// Evaluates its textures at a point and builds a BxDF of numbers. Immutable and thread-safe.
class Material {
  public:
    virtual ~Material() = default;
    /// A BxDF in `arena`, or null where nothing scatters. A dispersive index terminates the secondary
    /// wavelengths.
    virtual BxDF* MakeBxDF(const TextureContext& context, SampledWavelengths& lambda, Arena& arena) const = 0;
    /// What the light does that refracts into the surface made by MakeBxDF(), in `arena`. Default: null, it
    /// goes on through what is behind the surface. Renderers that cannot say where it leaves see the BxDF
    /// only.
    virtual BSSRDF* MakeBSSRDF(const TextureContext& /*context*/, const SampledWavelengths& /*lambda*/,
                               Arena& /*arena*/) const {
        return nullptr;
    }
    /// True if MakeBSSRDF() gives something somewhere.
    virtual bool HasSubsurface() const { return false; }
    /// The same for an interface between the media of a stack. Where `media` says what lies below, a
    /// dielectric that was given no index of its own takes the quotient; the index of a conductor is divided
    /// by that above. Default: MakeBxDF().
    virtual BxDF* MakeInterface(const TextureContext& context, SampledWavelengths& lambda, Arena& arena,
                                const InterfaceMedia& /*media*/) const {
        return MakeBxDF(context, lambda, arena);
    }
    /// Index below over index above of what MakeInterface() makes, as its refraction has it. Default: 1.
    virtual float InterfaceEta(SampledWavelengths& /*lambda*/, const InterfaceMedia& /*media*/) const {
        return 1;
    }
    /// The material to use at this point: `this`, or the one that a mixture draws. The draw is a hash of
    /// position and direction, so that repeated queries of one hit agree.
    virtual const Material* Choose(const TextureContext& /*context*/, Vec3 /*wo*/) const { return this; }
    /// True for the surface that is not there: rays continue, media change.
    virtual bool IsInterface() const { return false; }
    /// True if light can pass to the other side somewhere.
    virtual bool Transmits() const { return false; }
    /// Why no shape can have this material; empty if one can.
    virtual std::string WhyNotASurface() const { return {}; }
    /// Why this surface cannot be an interface of a stack; empty if it can.
    virtual std::string WhyNotAnInterface() const { return {}; }
    /// True for what takes the place of a material that could not be made.
    virtual bool IsStandIn() const { return false; }
    /// True if some texture needs a footprint to be filtered.
    virtual bool NeedsFootprint() const { return true; }

    /// Perturbs the shading frame by the displacement texture or the normal map, where there is one, then
    /// turns its tangents about the normal.
    void Bump(SurfaceInteraction& si) const {
        if (HasBump()) PerturbShading(si);
    }
    bool HasBump() const { return displacement_ || normalMap_ || rotation_; }
    /// The perturbed frame in the local frame of the unperturbed surface: z along the normal, x along the
    /// projected tangent, turned. Without a `context.surface` the tangents are unit vectors. The identity
    /// where the normal would point below the surface. Cost  of a bump; only worth asking for where
    /// HasBump().
    Frame BumpedFrame(const TextureContext& context) const;
    /// `"displacement"`, `"normalmap"` and `"rotation"` (degrees), common to nearly all materials.
    void ReadBump(const Params& params, TextureLibrary& textures);

  private:
    void PerturbShading(SurfaceInteraction& si) const;
    const FloatTexture* displacement_ = nullptr;
    const FloatTexture* rotation_ = nullptr;
    std::shared_ptr<const Image> normalMap_;
};

/// Stands for a material that could not be made, until the errors are reported. Never rendered.
class StandInMaterial final : public Material {
  public:
    BxDF* MakeBxDF(const TextureContext&, SampledWavelengths&, Arena&) const override { return nullptr; }
    bool IsStandIn() const override { return true; }
};

/// What the command line says about all layered materials; empty: what the scene says.
struct LayeredOverrides {
    std::string estimator, pdf;
};

/// What a material's factory gets. `named` holds the named materials that were made before this one.
struct MaterialArgs {
    const Params& params;
    TextureLibrary& textures;
    const std::map<std::string, const Material*>& named;
    std::string_view name = {};  ///< of a named material
    const LayeredOverrides* layered = nullptr;
};
struct MaterialKind {
    static constexpr const char* kKind = "material";
    using Factory = std::unique_ptr<Material> (*)(const MaterialArgs&);
};

}  // namespace lacquer
