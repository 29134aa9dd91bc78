// Texture "imagemap": an image, filtered over the texture footprint.
//
//   "string filename"      required       the image
//   "string filter"        bilinear       or "point", "trilinear", "ewa" ("EWA")
//   "float maxanisotropy"  8              longest over shortest axis of the ellipse of "ewa", 1 to 64
//   "string wrap"          repeat         outside of [0, 1]^2: or "clamp", "black", "octahedralsphere"
//   "string encoding"      from the file  "sRGB" (of PNG), "linear" (of others), or "gamma x" with x from
//                                         0.01 to 100
//   "float scale"          1              multiplies the values
//   "bool invert"          false          1 - value, after the scale
//   "mapping", "uscale", "vscale", "udelta", "vdelta", "v1", "v2": see texture_mapping.h
#include "pbrt/textures/imagemap.h"

#include <cctype>
#include <filesystem>
#include <limits>

#include "pbrt/image/image_cache.h"
#include "pbrt/image/mipmap.h"
#include "pbrt/textures/finite_params.h"
#include "pbrt/textures/texture_mapping.h"

namespace lacquer {

namespace {

/// What float and spectrum image textures have in common. Copies share the mapping and the pyramid.
struct ImageLookup {
    std::shared_ptr<const TextureMapping2D> mapping;
    std::shared_ptr<const MipMap> map;
    TextureFilter filter = TextureFilter::Bilinear;
    float maxAnisotropy = 8, scale = 1;
    bool invert = false;
    bool isMean = false;  ///< the mean of the image everywhere

    /// Image rows go down where t goes up.
    TextureFootprint Footprint(const TextureContext& context) const {
        // A footprint of many images has the mean in all filters.
        constexpr float kWide = 1e6f;
        if (isMean) return {Point2(0), {kWide, 0}, {0, kWide}};
        TextureFootprint f = mapping->Map(context);
        f.st.y = 1 - f.st.y;
        f.dstdx.y = -f.dstdx.y;
        f.dstdy.y = -f.dstdy.y;
        return f;
    }
    /// The scale comes before the inversion, as in pbrt.
    float ScaleAndInvert(float v) const { return invert ? std::max(0.f, 1 - scale * v) : scale * v; }
    void MultiplyScale(float factor) { scale *= factor; }
};

class FloatImageMap final : public FloatTexture {
  public:
    explicit FloatImageMap(ImageLookup lookup) : lookup_(std::move(lookup)) {}
    float Evaluate(const TextureContext& context) const override {
        return lookup_.ScaleAndInvert(
            lookup_.map->FilterFloat(lookup_.Footprint(context), lookup_.filter, lookup_.maxAnisotropy));
    }
    const ImageLookup& Lookup() const { return lookup_; }

  private:
    ImageLookup lookup_;
};

class SpectrumImageMap final : public SpectrumTexture {
  public:
    SpectrumImageMap(ImageLookup lookup, SpectrumKind kind) : lookup_(std::move(lookup)), kind_(kind) {}
    SampledSpectrum Evaluate(const TextureContext& context, const SampledWavelengths& lambda) const override {
        RGB rgb = lookup_.map->FilterRGB(lookup_.Footprint(context), lookup_.filter, lookup_.maxAnisotropy);
        for (int i = 0; i < 3; ++i) rgb[i] = lookup_.ScaleAndInvert(rgb[i]);
        return SampleRGB(lookup_.map->ColorSpace(), rgb, kind_, lambda);
    }
    const ImageLookup& Lookup() const { return lookup_; }
    SpectrumKind Kind() const { return kind_; }

  private:
    ImageLookup lookup_;
    SpectrumKind kind_;
};

TextureFilter ReadFilter(const Params& params) {
    const std::string name =
        params.GetChoice("filter", "bilinear", {"point", "bilinear", "trilinear", "ewa", "EWA"});
    if (name == "point") return TextureFilter::Point;
    if (name == "trilinear") return TextureFilter::Trilinear;
    return name == "bilinear" ? TextureFilter::Bilinear : TextureFilter::EWA;
}

/// sRGB unless stated for .png, linear for others (whose 8-bit formats are sRGB in any case).
ColorEncoding ReadEncoding(const Params& params, const std::string& path) {
    const std::string text = params.GetString("encoding", ExtensionOf(path) == "png" ? "sRGB" : "linear");
    const std::optional<ColorEncoding> encoding = ColorEncoding::Parse(text);
    if (!encoding)
        params.Fail("encoding", "\"string encoding\" is \"" + text +
                                    "\"; expected \"sRGB\", \"linear\" or \"gamma x\" with x "
                                    "from 0.01 to 100");
    return *encoding;
}

TextureImage ReadImageName(const Params& params) {
    const std::string wrap =
        params.GetChoice("wrap", "repeat", {"repeat", "clamp", "black", "octahedralsphere"});
    const std::string path = params.GetString("filename", "");
    if (path.empty()) params.Fail("filename", "texture \"imagemap\" needs \"string filename\"");
    const ColorEncoding encoding = ReadEncoding(params, path);
    return {params.PathOf("filename"), encoding, *ParseWrapMode(wrap)};
}

ImageLookup ReadLookup(const TextureArgs& args) {
    const Params& params = args.params;
    ImageLookup lookup;
    lookup.mapping = MakeTextureMapping2D(args);
    lookup.filter = ReadFilter(params);
    constexpr float kHuge = std::numeric_limits<float>::max();
    lookup.maxAnisotropy =
        std::min(params.GetFloatInRange("maxanisotropy", 8, 1, kHuge), MipMap::kMaxAnisotropy);
    lookup.scale = FiniteFloat(params, "scale", 1);
    lookup.invert = params.GetBool("invert", false);
    lookup.isMean = args.textures.WantsMeansOfImages();
    lookup.map = args.textures.Images().GetMipMap(ReadImageName(params), params.LocOf("filename"));
    return lookup;
}

std::unique_ptr<FloatTexture> CreateFloat(const TextureArgs& args) {
    return std::make_unique<FloatImageMap>(ReadLookup(args));
}

std::unique_ptr<SpectrumTexture> CreateSpectrum(const TextureArgs& args) {
    return std::make_unique<SpectrumImageMap>(ReadLookup(args), args.kind);
}

}  // namespace

std::unique_ptr<FloatTexture> ScaledImageMap(const FloatTexture& texture, float factor) {
    const auto* image = dynamic_cast<const FloatImageMap*>(&texture);
    if (!image) return nullptr;
    ImageLookup lookup = image->Lookup();
    lookup.MultiplyScale(factor);
    return std::make_unique<FloatImageMap>(std::move(lookup));
}

std::unique_ptr<SpectrumTexture> ScaledImageMap(const SpectrumTexture& texture, float factor) {
    const auto* image = dynamic_cast<const SpectrumImageMap*>(&texture);
    if (!image) return nullptr;
    ImageLookup lookup = image->Lookup();
    lookup.MultiplyScale(factor);
    return std::make_unique<SpectrumImageMap>(std::move(lookup), image->Kind());
}

const MipMap* ImageOf(const FloatTexture& texture) {
    const auto* image = dynamic_cast<const FloatImageMap*>(&texture);
    return image ? image->Lookup().map.get() : nullptr;
}

const MipMap* ImageOf(const SpectrumTexture& texture) {
    const auto* image = dynamic_cast<const SpectrumImageMap*>(&texture);
    return image ? image->Lookup().map.get() : nullptr;
}

LACQUER_REGISTER(FloatTextureKind, "imagemap", CreateFloat, {.image = ReadImageName});
LACQUER_REGISTER(SpectrumTextureKind, "imagemap", CreateSpectrum, {.image = ReadImageName});

}  // namespace lacquer
