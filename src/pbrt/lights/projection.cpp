// Light "projection": a point light through an image, as from a slide projector, along +z of the light's
// space, with +y up and +x to the right as a viewer behind the projector sees it.
//
//   "string filename"  required   the image, with channels R, G and B
//   "float fov"        90         full angle over the shorter axis of the image, in (0, 180) [degrees]
//   "float scale"      1          multiplies the emission, >= 0
//   "float power"      not given  if > 0, scales the light to this total power
#include <fmt/format.h>

#include "pbrt/core/invertible.h"
#include "pbrt/core/registry.h"
#include "pbrt/core/sampling.h"
#include "pbrt/lights/emission.h"
#include "pbrt/lights/light_image.h"
#include "pbrt/lights/point_like.h"

namespace lacquer {

namespace {

/// The image on the plane z = 1 of the light's space, with its centre on the axis.
class Slide {
  public:
    /// @param image  has R, G, B    @param fovDeg  full angle of the shorter axis
    Slide(std::shared_ptr<const Image> image, float fovDeg)
        : image_(std::move(image)), space_(&image_->ColorSpaceOrSRGB()) {
        const Vec2 size(image_->Resolution());
        half_ = std::tan(Radians(fovDeg) / 2) * size / std::min(size.x, size.y);
    }

    /// Colour of the light that leaves along w, not negative. Black beside the image and behind the light.
    RGB Along(Vec3 w) const {
        if (!(w.z > 0)) return RGB(0);
        const Point2 st(0.5f + 0.5f * (w.x / w.z) / half_.x, 0.5f - 0.5f * (w.y / w.z) / half_.y);
        if (!(st.x >= 0 && st.x <= 1 && st.y >= 0 && st.y <= 1)) return RGB(0);
        const Int2 size = image_->Resolution();
        return Texel({NearestTexel(st.x, size.x), NearestTexel(st.y, size.y)});
    }
    /// Integral over solid angle of the luminance, in which white counts 1. As in pbrt-v4, a texel counts
    /// with the solid angle per area at its centre, cos^3(theta): right for all but images of a few texels.
    float Flux() const {
        const Int2 size = image_->Resolution();
        double sum = 0;
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                const Vec2 st = (Vec2(float(x), float(y)) + 0.5f) / Vec2(size);
                sum += double(space_->Luminance(Texel({x, y})) * Cos3(st));
            }
        return float(4 * double(half_.x) * double(half_.y) * sum / (double(size.x) * double(size.y)));
    }
    /// Luminous flux through each texel but for a common factor, in rows.
    std::vector<float> Fluxes() const {
        const Int2 size = image_->Resolution();
        std::vector<float> fluxes;
        fluxes.reserve(size_t(size.x) * size_t(size.y));
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x)
                fluxes.push_back(space_->Luminance(Texel({x, y})) *
                                 Cos3((Point2(float(x), float(y)) + 0.5f) / Vec2(size)));
        return fluxes;
    }
    /// Direction through a point of the unit square of the image, unit. @param solidAngle  d omega / d(st)
    Vec3 Through(Point2 st, float* solidAngle) const {
        *solidAngle = 4 * half_.x * half_.y * Cos3(st);
        return Normalize(Vec3(half_.x * (2 * st.x - 1), half_.y * (1 - 2 * st.y), 1));
    }
    /// Its inverse. @param w  unit, w.z > 0
    Point2 Onto(Vec3 w, float* solidAngle) const {
        *solidAngle = 4 * half_.x * half_.y * w.z * w.z * w.z;
        return {0.5f + 0.5f * (w.x / w.z) / half_.x, 0.5f - 0.5f * (w.y / w.z) / half_.y};
    }
    float LargestValue() const {
        const Int2 size = image_->Resolution();
        float largest = 0;
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) largest = std::max(largest, MaxComponent(Texel({x, y})));
        return largest;
    }
    /// Half of its width and height.
    Vec2 HalfSize() const { return half_; }
    const ColorSpace& Space() const { return *space_; }
    Int2 Size() const { return image_->Resolution(); }

  private:
    /// cos^3 of the angle with the axis.
    float Cos3(Point2 st) const {
        const Vec2 onPlane = half_ * (2.f * st - Vec2(1));
        const float cosTheta = 1 / std::sqrt(1 + Sqr(onPlane.x) + Sqr(onPlane.y));
        return cosTheta * cosTheta * cosTheta;
    }
    RGB Texel(Int2 p) const {
        return glm::max(RGB(image_->Get(p, 0), image_->Get(p, 1), image_->Get(p, 2)), 0.f);
    }

    std::shared_ptr<const Image> image_;
    const ColorSpace* space_;
    Vec2 half_;
};

class ProjectionLight final : public PointLikeLight<ProjectionLight> {
  public:
    /// @param scale  luminous intensity of white
    ProjectionLight(const Transform& renderFromLight, Slide slide, float scale)
        : PointLikeLight(renderFromLight.Point(Point3(0))),
          renderFromLight_(renderFromLight),
          solidAngles_(renderFromLight),
          slide_(std::move(slide)),
          distribution_(slide_.Fluxes(), slide_.Size().x, slide_.Size().y),
          power_(scale * slide_.Flux()),
          illuminantScale_(scale / kCieYIntegral) {}

    SampledSpectrum IntensityOver(Vec3 w, float distanceSquared, const SampledWavelengths& lambda) const {
        const RGB rgb = slide_.Along(renderFromLight_.InverseVector(w));
        if (!(MaxComponent(rgb) > 0)) return SampledSpectrum(0);
        return Intensity(rgb, lambda) / distanceSquared;
    }
    std::optional<LightEmission> SampleLe(Point2, Point2 uDirection,
                                          const SampledWavelengths& lambda) const override {
        float pdf = 0, solidAngle = 0;
        const Vec3 local = slide_.Through(distribution_.Sample(uDirection, &pdf), &solidAngle);
        return EmittedToward(Normalize(renderFromLight_.Vector(local)),
                             Intensity(slide_.Along(local), lambda),
                             pdf / solidAngle * solidAngles_.DensityFactor(local));
    }
    EmissionDensity PdfLe(Normal3, Vec3 w) const override {
        const Vec3 local = Normalize(renderFromLight_.InverseVector(w));
        if (!(local.z > 0)) return {1, 0};
        float solidAngle = 0;
        const Point2 st = slide_.Onto(local, &solidAngle);
        if (!(st.x >= 0 && st.x <= 1 && st.y >= 0 && st.y <= 1)) return {1, 0};
        return {1, distribution_.Pdf(st) / solidAngle * solidAngles_.DensityFactor(local)};
    }
    float Power() const override { return power_; }
    std::optional<LightBounds> Bounds() const override;

  private:
    /// @param rgb  of the slide
    SampledSpectrum Intensity(RGB rgb, const SampledWavelengths& lambda) const {
        return SampleRGB(slide_.Space(), rgb, SpectrumKind::Illuminant, lambda) * illuminantScale_;
    }

    Transform renderFromLight_;
    SolidAngleMap solidAngles_;
    Slide slide_;
    PiecewiseConstant2D distribution_;  ///< of its flux, on its unit square
    float power_;
    float illuminantScale_;  ///< factor for a texel's spectrum
};

std::optional<LightBounds> ProjectionLight::Bounds() const {
    LightBounds b = AllAround();
    // A cone of less than a right angle that holds the four corners holds all that lies between them. A
    // transform that shears can make it wider; then nothing is said about directions.
    const Vec3 axis = Normalize(renderFromLight_.Vector({0, 0, 1}));
    float cosCorner = 1;
    for (const float x : {-1.f, 1.f})
        for (const float y : {-1.f, 1.f}) {
            const Vec3 corner(x * slide_.HalfSize().x, y * slide_.HalfSize().y, 1);
            cosCorner = std::min(cosCorner, Dot(axis, Normalize(renderFromLight_.Vector(corner))));
        }
    if (!(cosCorner > 0)) return b;
    constexpr float kMargin = 0.01f;  // radians, for the rounding at the edge
    b.axis = axis;
    b.cosTheta_o = cosCorner;
    b.cosTheta_e = std::cos(kMargin);
    return b;
}

std::unique_ptr<Light> CreateProjection(const LightArgs& args) {
    const Params& params = args.params;
    RequireInvertible(params, args.renderFromLight);
    const float fov = params.GetFloat("fov", 90);
    if (!(fov > 0 && fov < 180))
        params.Fail("fov", fmt::format("fov is {} degrees; it must lie between 0 and 180", fov));
    std::shared_ptr<const Image> image = ReadLightImage(args);
    if (!image->HasRGB())
        params.Fail("filename",
                    fmt::format("{}: the image of a projection light needs the channels R, G and B",
                                params.GetString("filename", "")));
    Slide slide(std::move(image), fov);

    float scale = ReadScale(params);
    if (const float power = ReadQuantity(params, "power"); power > 0) {
        const float flux = slide.Flux();
        if (!(flux > 0)) params.Fail("power", "the image is black: no scale gives this light a power");
        scale = RequireFinite(params, "power", scale * (power / flux));
    }
    RequireFinite(params, "filename", slide.LargestValue() * scale);
    return std::make_unique<ProjectionLight>(args.renderFromLight, std::move(slide), scale);
}

}  // namespace

LACQUER_REGISTER(LightKind, "projection", CreateProjection);

}  // namespace lacquer
