// Functions over surfaces.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "pbrt/base/interaction.h"
#include "pbrt/core/params.h"
#include "pbrt/core/registry.h"
#include "pbrt/core/transform.h"

namespace lacquer {

struct ColorEncoding;
class Image;
class ImageCache;
struct TextureImage;

/// Where a texture is looked up, in rendering space.
struct TextureContext {
    Point3 p{0};
    Vec3 dpdx{0}, dpdy{0};  ///< footprint; zero means a point
    Normal3 n{0};           ///< shading normal
    Point2 uv{0};
    float dudx = 0, dudy = 0, dvdx = 0, dvdy = 0;
    int faceIndex = 0;
    /// The point with its tangents, where there is one; it must outlive the context.
    const SurfaceInteraction* surface = nullptr;

    TextureContext() = default;
    explicit TextureContext(const SurfaceInteraction& si)
        : p(si.p),
          dpdx(si.dpdx),
          dpdy(si.dpdy),
          n(si.shading.n),
          uv(si.uv),
          dudx(si.dudx),
          dudy(si.dudy),
          dvdx(si.dvdx),
          dvdy(si.dvdy),
          faceIndex(si.faceIndex),
          surface(&si) {}
};

/// Immutable and thread-safe after its construction, like all scene objects.
class FloatTexture {
  public:
    virtual ~FloatTexture() = default;
    virtual float Evaluate(const TextureContext& context) const = 0;
    /// The value where it is the same everywhere.
    virtual std::optional<float> Constant() const { return std::nullopt; }
};

class SpectrumTexture {
  public:
    virtual ~SpectrumTexture() = default;
    virtual SampledSpectrum Evaluate(const TextureContext& context,
                                     const SampledWavelengths& lambda) const = 0;
    /// True where the value is the same everywhere (no footprint is needed).
    virtual bool IsConstant() const { return false; }
};

/// Owns the textures of a scene and finds them by name.
class TextureLibrary {
  public:
    virtual ~TextureLibrary() = default;
    /// A named texture. Errors: SceneError at `loc` for an unknown name (with the nearest one) or a texture
    /// that depends on itself. A spectrum texture exists once for each kind in which it is used.
    virtual const FloatTexture* Float(const std::string& name, const FileLoc& loc) = 0;
    virtual const SpectrumTexture* Spectrum(const std::string& name, SpectrumKind kind,
                                            const FileLoc& loc) = 0;
    /// Takes ownership of a texture without a name.
    virtual const FloatTexture* Own(std::unique_ptr<FloatTexture> texture) = 0;
    virtual const SpectrumTexture* Own(std::unique_ptr<SpectrumTexture> texture) = 0;
    virtual ImageCache& Images() = 0;
    /// True if image textures are to have their mean everywhere.
    virtual bool WantsMeansOfImages() const { return false; }
};

/// `"float name" x` or `"texture name" "t"`, else the constant `fallback`. Never null.
const FloatTexture* FloatTextureParam(const Params& params, std::string_view name, float fallback,
                                      TextureLibrary& textures);
/// The same without a fallback: null if the parameter is not given.
const FloatTexture* OptionalFloatTextureParam(const Params& params, std::string_view name,
                                              TextureLibrary& textures);
/// A spectrum in any of its forms, or a texture, else the constant `fallback`. Never null.
const SpectrumTexture* SpectrumTextureParam(const Params& params, std::string_view name, SpectrumKind kind,
                                            float fallback, TextureLibrary& textures);
const SpectrumTexture* OptionalSpectrumTextureParam(const Params& params, std::string_view name,
                                                    SpectrumKind kind, TextureLibrary& textures);

/// The image in the file that `"string name"` names, which must be given; kept by the library.
/// Errors: those of ReadImage, at the parameter.
std::shared_ptr<const Image> ImageParam(const Params& params, std::string_view name,
                                        const ColorEncoding& encoding, TextureLibrary& textures);

/// What a texture's factory gets. CTM of the directive is texture to world.
struct TextureArgs {
    const Params& params;
    Transform renderFromTexture;
    TextureLibrary& textures;
    SpectrumKind kind = SpectrumKind::Albedo;  ///< spectrum textures: how the values will be used
};
/// What is asked of a texture before it is made.
struct TextureTraits {
    /// The image that a texture of these parameters reads, so that many are read at the same time; null:
    /// none.
    TextureImage (*image)(const Params& params) = nullptr;
};
struct FloatTextureKind {
    static constexpr const char* kKind = "float texture";
    using Traits = TextureTraits;
    using Factory = std::unique_ptr<FloatTexture> (*)(const TextureArgs&);
};
struct SpectrumTextureKind {
    static constexpr const char* kKind = "spectrum texture";
    using Traits = TextureTraits;
    using Factory = std::unique_ptr<SpectrumTexture> (*)(const TextureArgs&);
};

}  // namespace lacquer
