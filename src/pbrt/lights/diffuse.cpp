// Area light "diffuse": every point of a shape emits the same radiance in all directions of its front, or of
// both sides.
//
//   "spectrum L"       the colour space's illuminant  radiance
//   "string filename"  -                              instead of L: an image of the radiance over (u, v)
//   "float scale"      1                              multiplies the emission, >= 0
//   "bool twosided"    false                          emits from the back as well
//   "float power"      not given                      if > 0, scales the light to this total power
#include <fmt/format.h>

#include <tuple>

#include "pbrt/base/shape.h"
#include "pbrt/core/registry.h"
#include "pbrt/core/rng.h"
#include "pbrt/core/sampling.h"
#include "pbrt/image/image_cache.h"
#include "pbrt/lights/emission.h"

namespace lacquer {

namespace {

/// What all primitives of a shape share.
struct SharedEmission {
    SharedEmission(const Shape& emitter, const Params& params)
        : shape(emitter),
          radiance(ReadEmission(params, "L", 1)),
          isTwoSided(params.GetBool("twosided", false)) {}

    const Shape& shape;
    Emission radiance;  ///< at unit scale; without meaning where there is an image
    bool isTwoSided;
    const FloatTexture* alpha = nullptr;  ///< null where nothing is masked
    std::shared_ptr<const Image> image;   ///< null for the same radiance everywhere
    const ColorSpace* imageSpace = nullptr;
    float imageLuminance = 1;  ///< mean over the image, where white is 1

    /// Whether the radiance depends on it.
    bool ReadsUv() const { return image || alpha; }
    float Sides() const { return isTwoSided ? 2.f : 1.f; }
    SampledSpectrum Radiance(Point2 uv, const SampledWavelengths& lambda) const;
    bool IsMasked(Point3 p, Normal3 n, Point2 uv) const;
};

SampledSpectrum SharedEmission::Radiance(Point2 uv, const SampledWavelengths& lambda) const {
    if (!image) return radiance.Sample(lambda);
    // Images have their origin in the top left corner.
    const Point2 st(uv.x, 1 - uv.y);
    RGB rgb;
    for (int c = 0; c < 3; ++c) rgb[c] = std::max(0.f, image->Bilinear(st, c, WrapMode::Clamp));
    return SampleRGB(*imageSpace, rgb, SpectrumKind::Illuminant, lambda) * (1 / kCieYIntegral);
}

/// Decides by a hash of the point whether a partly transparent emitter is a hole there. Rays test alpha
/// before they get here: as in pbrt-v4, what they see fades with the square of alpha, what light samples
/// bring with alpha.
bool SharedEmission::IsMasked(Point3 p, Normal3 n, Point2 uv) const {
    if (!alpha) return false;
    TextureContext context;
    context.p = p;
    context.n = n;
    context.uv = uv;
    const float a = alpha->Evaluate(context);
    if (a >= 1) return false;
    return !(a > 0) || UnitFloat(Hash(p.x, p.y, p.z)) > a;
}

/// One primitive. Meshes make millions of these: they hold nothing that could be shared.
class DiffuseAreaLight final : public Light {
  public:
    /// @param isVisible  false if rays never hit the shape: then its samples count as those of a delta light
    DiffuseAreaLight(std::shared_ptr<const SharedEmission> shared, int primitive, float scale, bool isVisible)
        : Light(isVisible ? Kind::Area : Kind::DeltaPosition),
          primitive_(primitive),
          shared_(std::move(shared)),
          scale_(scale) {}

    std::optional<LightSample> SampleLi(const LightReference& ref, Point2 u,
                                        const SampledWavelengths& lambda) const override;
    float PdfLi(const LightReference& ref, Vec3, const SurfaceInteraction* hit) const override {
        if (IsDelta() || !hit) return 0;
        return shared_->shape.PdfSolidAngle(primitive_, ref, hit->p, hit->n);
    }
    std::optional<LightEmission> SampleLe(Point2 uPosition, Point2 uDirection,
                                          const SampledWavelengths& lambda) const override;
    EmissionDensity PdfLe(Normal3 n, Vec3 w) const override {
        const float cosTheta = shared_->isTwoSided ? std::abs(Dot(n, w)) : Dot(n, w);
        return {1 / shared_->shape.Area(primitive_), PdfCosineHemisphere(cosTheta) / shared_->Sides()};
    }
    SampledSpectrum L(Point3 p, Normal3 n, Point2 uv, Vec3 w,
                      const SampledWavelengths& lambda) const override {
        if (!shared_->isTwoSided && !(Dot(n, w) > 0)) return SampledSpectrum(0);
        if (shared_->IsMasked(p, n, uv)) return SampledSpectrum(0);
        return shared_->Radiance(uv, lambda) * scale_;
    }
    float Power() const override {
        const float radiance = shared_->image ? shared_->imageLuminance : shared_->radiance.luminance;
        return shared_->Sides() * Pi * shared_->shape.Area(primitive_) * radiance * scale_;
    }
    std::optional<LightBounds> Bounds() const override {
        LightBounds b;
        b.bounds = shared_->shape.Bounds(primitive_);
        std::tie(b.axis, b.cosTheta_o) = shared_->shape.NormalCone(primitive_);
        b.power = Power();
        b.twoSided = shared_->isTwoSided;
        return b;
    }

  private:
    int primitive_;
    std::shared_ptr<const SharedEmission> shared_;
    float scale_;
};

std::optional<LightSample> DiffuseAreaLight::SampleLi(const LightReference& ref, Point2 u,
                                                      const SampledWavelengths& lambda) const {
    const std::optional<ShapeSample> s =
        shared_->shape.SampleSolidAngle(primitive_, ref, u, shared_->ReadsUv());
    if (!s || !(s->pdf > 0)) return std::nullopt;
    const Vec3 d = s->p - ref.p;
    const float distanceSquared = LengthSquared(d);
    if (!(distanceSquared > 0)) return std::nullopt;
    const Vec3 wi = d / std::sqrt(distanceSquared);
    const SampledSpectrum radiance = L(s->p, s->n, s->uv, -wi, lambda);
    if (!radiance) return std::nullopt;
    if (IsDelta()) return LightSample{radiance / s->pdf, wi, 1, s->p, s->pError, s->n};
    return LightSample{radiance, wi, s->pdf, s->p, s->pError, s->n};
}

std::optional<LightEmission> DiffuseAreaLight::SampleLe(Point2 uPosition, Point2 uDirection,
                                                        const SampledWavelengths& lambda) const {
    const std::optional<ShapeSample> s = shared_->shape.SampleArea(primitive_, uPosition);
    if (!s || !(s->pdf > 0)) return std::nullopt;
    // Two sides share the first number.
    bool isBack = false;
    if (shared_->isTwoSided) {
        isBack = uDirection.x >= 0.5f;
        uDirection.x = std::min(2 * uDirection.x - (isBack ? 1.f : 0.f), OneMinusEpsilon);
    }
    Vec3 local = SampleCosineHemisphere(uDirection);
    const float pdf = PdfCosineHemisphere(local.z) / shared_->Sides();
    if (isBack) local.z = -local.z;
    LightEmission emitted;
    emitted.w = Frame::FromZ(s->n).FromLocal(local);
    emitted.L = L(s->p, s->n, s->uv, emitted.w, lambda);
    if (!emitted.L || !(pdf > 0)) return std::nullopt;
    emitted.p = s->p;
    emitted.pError = s->pError;
    emitted.n = s->n;
    emitted.uv = s->uv;
    emitted.pdfPosition = s->pdf;
    emitted.pdfDirection = pdf;
    return emitted;
}

/// Puts the image of `"string filename"` into `shared`, and the mean of its luminance.
void ReadEmissionImage(const AreaLightArgs& args, const std::string& filename, SharedEmission* shared) {
    const Params& params = args.params;
    shared->image = ImageParam(params, "filename", ColorEncoding{ColorEncoding::Kind::SRGB}, args.textures);
    const Image& image = *shared->image;
    if (!image.HasRGB())
        params.Fail("filename",
                    fmt::format("{}: an image of emission needs the channels R, G and B", filename));
    shared->imageSpace = &image.ColorSpaceOrSRGB();

    const Int2 size = image.Resolution();
    double sum = 0;
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const RGB rgb(image.Get({x, y}, 0), image.Get({x, y}, 1), image.Get({x, y}, 2));
            if (!IsFinite(rgb))
                params.Fail("filename",
                            fmt::format("{}: pixel ({}, {}) is not a finite number", filename, x, y));
            sum += double(shared->imageSpace->Luminance(glm::max(rgb, 0.f)));
        }
    shared->imageLuminance = float(sum / (double(size.x) * double(size.y)));
}

/// What the radiance of a primitive is multiplied by for a given power; 0 where it has no area or a black
/// image. The luminance of a coloured "rgb L" stays out of it and so multiplies the power, as in pbrt-v4.
float PowerScale(const SharedEmission& shared, int primitive, float power) {
    const float scale = power / (shared.Sides() * Pi * shared.shape.Area(primitive) * shared.imageLuminance);
    return std::isfinite(scale) ? scale : 0.f;
}

std::vector<std::unique_ptr<Light>> CreateDiffuse(const AreaLightArgs& args) {
    const Params& params = args.params;
    const std::optional<std::string> filename = params.GetOptionalString("filename");
    if (filename && params.Has("L"))
        params.Fail("L",
                    "a diffuse area light takes its radiance from \"L\" or from \"filename\", not from both");
    const float scale = ReadScale(params);
    const auto shared = std::make_shared<SharedEmission>(args.shape, params);
    if (filename) ReadEmissionImage(args, *filename, shared.get());
    RequireFinite(params, "scale", scale * shared->radiance.MaxValue());

    // Where alpha is 0 everywhere, the shape is an invisible lamp; where it is 1, there is nothing to mask.
    const std::optional<float> constantAlpha = args.alpha ? args.alpha->Constant() : 1.f;
    const bool isVisible = !(constantAlpha && *constantAlpha <= 0);
    if (!constantAlpha || (*constantAlpha > 0 && *constantAlpha < 1)) shared->alpha = args.alpha;

    const float power = ReadQuantity(params, "power");
    std::vector<std::unique_ptr<Light>> lights;
    lights.reserve(size_t(args.shape.NumPrimitives()));
    for (int i = 0; i < args.shape.NumPrimitives(); ++i) {
        const float factor = power > 0 ? PowerScale(*shared, i, power) : 1.f;
        lights.push_back(std::make_unique<DiffuseAreaLight>(shared, i, scale * factor, isVisible));
    }
    return lights;
}

}  // namespace

LACQUER_REGISTER(AreaLightKind, "diffuse", CreateDiffuse);

}  // namespace lacquer
