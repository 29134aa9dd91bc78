// Matter between two interfaces of a stack, as a named material.
#pragma once

#include "layered/stack.h"
#include "pbrt/base/material.h"
#include "pbrt/base/warnings.h"
#include "pbrt/materials/index_of_refraction.h"

namespace lacquer::layered {

/// Holds a slab's textures. It is no surface: only the stack of a layered material can use it.
class SlabMaterial final : public Material, public HasWarnings {
  public:
    struct Textures {
        IndexOfRefraction eta;
        const FloatTexture* thickness;   ///< in the unit of 1/sigma_t; negative values count as 0
        const SpectrumTexture* sigma_t;  ///< extinction per unit of thickness
        const SpectrumTexture* albedo;   ///< single-scattering albedo, clamped to [0,1]
    };
    SlabMaterial(Textures textures, std::unique_ptr<PhaseModel> phase, std::vector<Diagnostic> warnings = {})
        : textures_(std::move(textures)), phase_(std::move(phase)), warnings_(std::move(warnings)) {}

    /// Index of refraction relative to the vacuum; one that varies with wavelength ends the others.
    float Eta(SampledWavelengths& lambda) const { return textures_.eta.At(lambda); }
    /// The slab at a point; what it refers to is in `arena` or in this material. An extinction by direction
    /// that varies with the wavelength ends the others.
    /// @param frame  of the stack that it belongs to, in the frame of the outermost one
    Slab MakeSlab(const TextureContext& context, SampledWavelengths& lambda, const Frame& frame,
                  Arena& arena) const;
    const PhaseModel& Phase() const { return *phase_; }
    std::span<const Diagnostic> Warnings() const override { return warnings_; }

    /// Never asked for: see WhyNotASurface().
    BxDF* MakeBxDF(const TextureContext&, SampledWavelengths&, Arena&) const override { return nullptr; }
    bool NeedsFootprint() const override;
    bool Transmits() const override { return true; }
    std::string WhyNotASurface() const override {
        return "is a slab, which has no surface; expected a material that has one: slabs stand in the "
               "\"stack\" of a \"layered\" material";
    }

  private:
    Textures textures_;
    std::unique_ptr<PhaseModel> phase_;
    std::vector<Diagnostic> warnings_;
};

/// v of the inner frame, given in the outer one, for each axis.
inline Frame Nested(const Frame& outer, const Frame& inner) {
    return {outer.FromLocal(inner.x), outer.FromLocal(inner.y), outer.FromLocal(inner.z)};
}

}  // namespace lacquer::layered
