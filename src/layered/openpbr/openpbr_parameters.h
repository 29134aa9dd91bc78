// The parameters of OpenPBR surfaces.
#pragma once

#include "pbrt/base/texture.h"

namespace lacquer::layered {

/// An index whose reflectance at normal incidence is `weight` times that of `eta`.
float WeightedIndex(float eta, float weight);

/// All of them at one point, named as in version 1.1 of the specification [ASWF 2024], within its limits.
struct OpenPBRPoint {
    struct {
        float weight, diffuseRoughness, metalness;
        SampledSpectrum color;
    } base;
    struct {
        float weight, roughness, anisotropy, ior;
        SampledSpectrum color;
        float insideReflectance;  ///< of its interface in air, for diffuse light from inside
    } specular;
    struct {
        float weight, depth, dispersionScale, abbeNumber;
        SampledSpectrum color;
    } transmission;
    struct {
        float weight, anisotropy;
        SampledSpectrum color;
    } subsurface;
    struct {
        float weight, roughness;
        SampledSpectrum color;
    } fuzz;
    struct {
        float weight, roughness, anisotropy, ior;
        SampledSpectrum color;
    } coat;
    struct {
        float weight, thickness, ior;  ///< thickness in micrometers
    } thinFilm;
    float opacity;
};

class OpenPBRTextures {
  public:
    /// Reads the parameters, each a number or a colour of its type, or a texture. Errors: SceneError for
    /// numbers beyond the specification's limits.
    static OpenPBRTextures Read(const Params& params, TextureLibrary& textures);

    OpenPBRPoint At(const TextureContext& context, const SampledWavelengths& lambda) const;
    bool IsConstant() const;
    /// True if some light may pass to the other side.
    bool MayTransmit() const;
    /// geometry_opacity, unless a texture gives it.
    std::optional<float> ConstantOpacity() const;
    /// True if a coat or fuzz may lie on some part of the surface.
    bool HasCoatOrFuzz() const;
    /// The weights alone: what chooses among the specification's mixtures.
    struct Weights {
        float metalness, transmission, subsurface, coat, fuzz, thinFilm, opacity;
    };
    Weights WeightsAt(const TextureContext& context) const;

  private:
    /// Numbers and colours, in the order of the tables in openpbr_parameters.cpp.
    static constexpr size_t kNumbers = 23, kColors = 6;
    std::optional<float> insideReflectance_;  ///< where it is the same everywhere
    std::array<const FloatTexture*, kNumbers> numbers_{};
    std::array<const SpectrumTexture*, kColors> colors_{};
};

}  // namespace lacquer::layered
