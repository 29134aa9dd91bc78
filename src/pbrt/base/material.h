// From textures to scattering: what a surface is made of.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "pbrt/base/bssrdf.h"
#include "pbrt/base/bxdf.h"
#include "pbrt/base/texture.h"
#include "pbrt/core/arena.h"
#include "pbrt/core/registry.h"

namespace lacquer {

/// A surface: evaluates its textures at a point and builds a BxDF of numbers. Immutable and thread-safe. What
/// it is inside of a stack of layers is a role of its own (stack_boundary.h).
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
    /// Why its stacks do not count vertices (BxDF::CountsVertices); empty if they do or if it makes none.
    virtual std::string WhyNoVertices() const { return {}; }
    /// The material to use at this point: `this`, or the one that a mixture draws. The draw is a hash of
    /// position and direction, so that repeated queries of one hit agree.
    virtual const Material* Choose(const TextureContext& /*context*/, Vec3 /*wo*/) const { return this; }
    /// True for the surface that is not there: rays continue, media change.
    virtual bool IsInvisible() const { return false; }
    /// True if light can pass to the other side somewhere.
    virtual bool Transmits() const { return false; }
    /// Why no shape can have this material; empty if one can.
    virtual std::string WhyNotASurface() const { return {}; }
    /// True for what takes the place of a material that could not be made.
    virtual bool IsPlaceholder() const { return false; }
    /// True if the camera sees a hole in place of its surfaces: no light, and alpha 0. All other rays meet
    /// them.
    bool IsHoldout() const { return isHoldout_; }
    void SetHoldout(bool isHoldout) { isHoldout_ = isHoldout; }
    /// True if some texture needs a footprint to be filtered, or HasBump(), here or in what the material is
    /// made of: bumps find derivatives of normals only then.
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
    bool isHoldout_ = false;
};

/// Stands for a material that could not be made, until the errors are reported. Never rendered.
class PlaceholderMaterial final : public Material {
  public:
    BxDF* MakeBxDF(const TextureContext&, SampledWavelengths&, Arena&) const override { return nullptr; }
    bool IsPlaceholder() const override { return true; }
};

/// String parameters, by name, that the command line sets for all materials that have them, whatever the
/// scene says. An empty value sets nothing.
using MaterialOverrides = std::map<std::string, std::string>;

/// What a material's factory gets. `named` holds the named materials that were made before this one.
struct MaterialArgs {
    const Params& params;
    TextureLibrary& textures;
    const std::map<std::string, const Material*>& named;
    std::string_view name = {};                    ///< of a named material
    const MaterialOverrides* overrides = nullptr;  ///< null: none

    /// What the command line sets `parameter` to; empty: nothing.
    std::string Override(const std::string& parameter) const {
        if (!overrides) return {};
        const auto found = overrides->find(parameter);
        return found == overrides->end() ? std::string() : found->second;
    }
};
struct MaterialKind {
    static constexpr const char* kKind = "material";
    using Factory = std::unique_ptr<Material> (*)(const MaterialArgs&);
    struct Traits {
        /// A stack whose value is estimated: it takes "estimator" and "pdf", of MaterialOverrides, too.
        bool isLayered = false;
    };
};

}  // namespace lacquer
