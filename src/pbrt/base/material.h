// From textures to scattering: what a surface is made of.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "pbrt/base/bxdf.h"
#include "pbrt/base/texture.h"
#include "pbrt/core/arena.h"
#include "pbrt/core/registry.h"

namespace lacquer {

/// Evaluates its textures at a point and builds a BxDF of numbers. Immutable and thread-safe.
class Material {
  public:
    virtual ~Material() = default;
    /// A BxDF in `arena`, or null where nothing scatters. A dispersive index terminates the secondary
    /// wavelengths.
    virtual BxDF* MakeBxDF(const TextureContext& context, SampledWavelengths& lambda,
                                 Arena& arena) const = 0;
    /// The material to use at this point: `this`, or the one that a mixture draws. The draw is a hash of
    /// position and direction, so that repeated queries of one hit agree.
    virtual const Material* Choose(const TextureContext& /*context*/, Vec3 /*wo*/) const { return this; }
    /// True for the surface that is not there: rays continue, media change.
    virtual bool IsInterface() const { return false; }
    /// True if some texture needs a footprint to be filtered.
    virtual bool NeedsFootprint() const { return true; }

    /// Perturbs the shading frame by the displacement texture or the normal map, where there is one.
    void Bump(SurfaceInteraction& si) const {
        if (displacement_ || normalMap_) PerturbShading(si);
    }
    bool HasBump() const { return displacement_ || normalMap_; }
    /// `"displacement"` and `"normalmap"`, common to nearly all materials.
    void ReadBump(const Params& params, TextureLibrary& textures);

  private:
    void PerturbShading(SurfaceInteraction& si) const;
    const FloatTexture* displacement_ = nullptr;
    std::shared_ptr<const Image> normalMap_;
};

/// What a material's factory gets. `named` holds the named materials that were made before this one.
struct MaterialArgs {
    const Params& params;
    TextureLibrary& textures;
    const std::map<std::string, const Material*>& named;
};
struct MaterialKind {
    static constexpr const char* kKind = "material";
    using Factory = std::unique_ptr<Material> (*)(const MaterialArgs&);
};

}  // namespace lacquer
