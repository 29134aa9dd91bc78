// Light "infinite": radiance from all directions, the same everywhere or given by an image.
//
//   "spectrum L"         the colour space's illuminant  radiance; with a portal, "rgb" or an illuminant
//   "string filename"    -                              instead of L: an image of all directions
//   "string mapping"     "equalarea", or "latlong" if   how they lie in it: "equalarea" (a square, octahedral
//                        the image has twice as many    [Clarberg 2008]), "latlong", "mirrorball", "angular"
//                        columns as rows
//   "float scale"        1                              multiplies the emission, >= 0
//   "float illuminance"  not given                      if > 0, scales the light to this illuminance of an
//                                                       upward-facing surface
//   "string model"       -                              "sky": sun and sky, with the parameters in sky.cpp
//   "point3 portal" [4]  -                              corners of a rectangle in world space through which
//                                                       alone the light enters
#include "pbrt/lights/infinite.h"

#include <fmt/format.h>

#include "pbrt/core/invertible.h"
#include "pbrt/core/progress.h"
#include "pbrt/core/registry.h"
#include "pbrt/core/sampling.h"
#include "pbrt/image/environment.h"
#include "pbrt/image/image_cache.h"
#include "pbrt/lights/emission.h"
#include "pbrt/lights/light_image.h"

namespace lacquer {

namespace {

class UniformInfiniteLight final : public Light {
  public:
    explicit UniformInfiniteLight(Emission radiance)
        : Light(Kind::Infinite), radiance_(std::move(radiance)) {}

    void Preprocess(const Bounds3& sceneBounds) override { sceneSphere_ = BoundingSphereOf(sceneBounds); }
    SampledSpectrum Le(const Ray&, const SampledWavelengths& lambda) const override {
        return radiance_.Sample(lambda);
    }
    std::optional<LightSample> SampleLi(const LightReference& ref, Point2 u,
                                        const SampledWavelengths& lambda) const override {
        const SampledSpectrum L = radiance_.Sample(lambda);
        if (!L) return std::nullopt;
        const Vec3 wi = SampleUniformSphere(u);
        return LightSample{L, wi, PdfUniformSphere(), ref.p + 2 * sceneSphere_.radius * wi, 0, Normal3(0)};
    }
    float PdfLi(const LightReference&, Vec3, const SurfaceInteraction*) const override {
        return PdfUniformSphere();
    }
    std::optional<LightEmission> SampleLe(Point2 uPosition, Point2 uDirection,
                                          const SampledWavelengths& lambda) const override {
        const SampledSpectrum L = radiance_.Sample(lambda);
        if (!L) return std::nullopt;
        return EmissionThroughSphere(sceneSphere_, SampleUniformSphere(uDirection), L, uPosition,
                                     PdfUniformSphere());
    }
    EmissionDensity PdfLe(Normal3, Vec3) const override {
        return {PdfThroughSphere(sceneSphere_), PdfUniformSphere()};
    }
    bool IsUniformInfinite() const override { return true; }
    float Power() const override { return 4 * Pi * Pi * Sqr(sceneSphere_.radius) * radiance_.luminance; }

  private:
    Emission radiance_;
    BoundingSphere sceneSphere_;
};

/// `"string mapping"`; without it, an image of the size that only one of them has tells.
EnvironmentMapping MappingOf(const LightArgs& args, const std::string& filename, Int2 size) {
    const bool isGiven = args.params.Has("mapping");
    const std::string name = args.params.GetChoice("mapping", "equalarea", EnvironmentMappingNames());
    if (isGiven || size.x != 2 * size.y) return EnvironmentMappingOf(name);
    if (args.observer)
        args.observer->Warn(Diagnostic{
            Diagnostic::Severity::Warning,
            args.params.LocOf("filename"),
            fmt::format("{}: {} x {} pixels are taken as a latitude-longitude map; \"string "
                        "mapping\" \"latlong\" says so",
                        filename, size.x, size.y),
            {}}.ToString());
    return EnvironmentMapping::LatLong;
}

/// The image of `"string filename"`, checked, in the equal-area mapping.
std::shared_ptr<const Image> ReadMap(const LightArgs& args, const std::string& filename) {
    const Params& params = args.params;
    std::shared_ptr<const Image> image =
        ImageParam(params, "filename", ColorEncoding{ColorEncoding::Kind::SRGB}, args.textures);
    const EnvironmentMapping mapping = MappingOf(args, filename, image->Resolution());
    if (const std::string why = WhyNotOfMapping(image->Resolution(), mapping); !why.empty())
        params.Fail("filename", fmt::format("{}: {}", filename, why));
    if (!image->HasRGB())
        params.Fail("filename",
                    fmt::format("{}: an environment map needs the channels R, G and B", filename));
    RequireFinitePixels(params, filename, *image, 3);
    if (mapping == EnvironmentMapping::EqualArea) return image;
    return std::make_shared<Image>(ToEqualArea(*image, mapping, EqualAreaSide(image->Resolution(), mapping)));
}

/// A map of one texel with the colour of `"L"`, or white.
std::shared_ptr<const Image> MapOfOneColor(const Params& params) {
    const Emission unit = ReadEmission(params, "L", 1);
    const RGB rgb = ColorSpace::SRGB().ToRGB(SpectrumToXYZ(*unit.spectrum) * (unit.scale * kCieYIntegral));
    auto image = std::make_shared<Image>(Int2(1, 1), std::vector<std::string>{"R", "G", "B"});
    for (int c = 0; c < 3; ++c) image->Set({0, 0}, c, std::max(0.f, rgb[c]));
    image->SetColorSpace(&ColorSpace::SRGB());
    return image;
}

/// Illuminance below the upper hemisphere of a map as pbrt-v4 takes it: 2 pi / N times the sum of Y
/// cos(theta). A texel has the solid angle 4 pi / N, so this is half of the true value; and in an EXR file,
/// whose channels stand in alphabetical order, the luminance weights of R and B are exchanged. Images made
/// for pbrt rely on both.
float PbrtIlluminance(const EnvironmentMap& map, const std::string& filename) {
    const bool exchanged = filename.ends_with(".exr") || filename.ends_with(".EXR");
    const int n = map.Size();
    double sum = 0;
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) {
            const Vec3 w = EqualAreaSquareToSphere((Point2(float(x), float(y)) + 0.5f) / float(n));
            RGB rgb = map.Texel({x, y});
            if (exchanged) std::swap(rgb.x, rgb.z);
            if (w.z > 0) sum += double(map.Space().Luminance(rgb) * w.z);
        }
    return float(2 * double(Pi) / (double(n) * n) * sum);
}

/// The rectangle of `"point3 portal"`. It is given in world space: the light's own transform does not move
/// it.
Portal ReadPortal(const LightArgs& args, const std::vector<Vec3>& points) {
    const Params& params = args.params;
    if (points.size() != 4)
        params.Fail("portal",
                    fmt::format("expected the four corners of a rectangle, found {} points", points.size()));
    Portal portal;
    for (size_t i = 0; i < 4; ++i) portal.corners[i] = args.renderFromWorld.Point(points[i]);
    const auto& p = portal.corners;

    // Opposite edges must be parallel, neighbouring ones at right angles (to one part in a thousand, as in
    // pbrt-v4).
    constexpr float kTolerance = 1e-3f;
    const Vec3 p01 = Normalize(p[1] - p[0]), p12 = Normalize(p[2] - p[1]);
    const Vec3 p32 = Normalize(p[2] - p[3]), p03 = Normalize(p[3] - p[0]);
    const bool parallel =
        std::abs(Dot(p01, p32) - 1) < kTolerance && std::abs(Dot(p12, p03) - 1) < kTolerance;
    const bool rightAngles = std::abs(Dot(p01, p12)) < kTolerance && std::abs(Dot(p01, p03)) < kTolerance;
    portal.area = Length(p[1] - p[0]) * Length(p[3] - p[0]);
    if (!parallel || !rightAngles || !(portal.area > 0) || !std::isfinite(portal.area))
        params.Fail("portal", "a portal must be a planar rectangle of positive area, its corners in order");
    portal.frame = Frame::FromZX(Normalize(Cross(p03, p01)), p03);
    return portal;
}

std::unique_ptr<Light> CreateUniform(const LightArgs& args) {
    Emission radiance = ReadEmission(args.params, "L", ReadScale(args.params));
    if (const float illuminance = ReadQuantity(args.params, "illuminance"); illuminance > 0) {
        radiance.Scale(illuminance / Pi);
        RequireFinite(args.params, "illuminance", radiance.luminance);
    }
    return std::make_unique<UniformInfiniteLight>(std::move(radiance));
}

std::unique_ptr<Light> CreateInfinite(const LightArgs& args) {
    const Params& params = args.params;
    if (params.GetChoice("model", "", {"sky"}) == "sky") {
        for (const char* other : {"filename", "mapping", "L", "portal"})
            if (params.Has(other))
                params.Fail(other, fmt::format("\"{}\" does not go with \"string model\" \"sky\", which is "
                                               "light from everywhere",
                                               other));
        return MakeSkyLight(args);
    }
    const std::optional<std::string> filename = params.GetOptionalString("filename");
    if (!filename && params.Has("mapping"))
        params.Fail("mapping", "\"mapping\" belongs to an image, and no \"string filename\" is given");
    const std::vector<Vec3> portal = params.GetPoint3s("portal");
    if (filename && params.Has("L"))
        params.Fail(
            "L",
            "an infinite light takes its radiance either from \"L\" or from \"filename\", not from both");
    if (!filename && portal.empty()) return CreateUniform(args);
    RequireInvertible(params, args.renderFromLight);

    // An image, or one colour in the form of an image for the portal.
    EnvironmentMap map;
    map.image = filename ? ReadMap(args, *filename) : MapOfOneColor(params);
    map.scale = ReadScale(params) / kCieYIntegral;
    if (const float illuminance = ReadQuantity(params, "illuminance"); illuminance > 0)
        map.scale *= illuminance / PbrtIlluminance(map, filename.value_or(""));
    RequireFinite(params, "illuminance", map.scale);
    if (portal.empty()) return MakeImageInfiniteLight(args.renderFromLight, map);
    return MakePortalInfiniteLight(args.renderFromLight, map, ReadPortal(args, portal));
}

}  // namespace

LACQUER_REGISTER(LightKind, "infinite", CreateInfinite);

}  // namespace lacquer
