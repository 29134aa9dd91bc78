// Light from one point, the same in all directions.
#include "pbrt/core/registry.h"
#include "pbrt/core/sampling.h"
#include "pbrt/lights/emission.h"

namespace lacquer {

namespace {

class PointLight final : public Light {
  public:
    PointLight(Point3 p, Emission intensity)
        : Light(Kind::DeltaPosition), p_(p), intensity_(std::move(intensity)) {}

    std::optional<LightSample> SampleLi(const LightReference& ref, Point2,
                                        const SampledWavelengths& lambda) const override {
        const Vec3 d = p_ - ref.p;
        const float distanceSquared = LengthSquared(d);
        if (!(distanceSquared > 0)) return std::nullopt;
        const SampledSpectrum L = intensity_.spectrum.Sample(lambda) / distanceSquared;
        if (!L) return std::nullopt;
        return LightSample{L, d / std::sqrt(distanceSquared), 1, p_, 0, Normal3(0)};
    }
    float PdfLi(const LightReference&, Vec3, const SurfaceInteraction*) const override { return 0; }
    std::optional<LightEmission> SampleLe(Point2, Point2 uDirection,
                                          const SampledWavelengths& lambda) const override {
        LightEmission emitted;
        emitted.L = intensity_.spectrum.Sample(lambda);
        if (!emitted.L) return std::nullopt;
        emitted.w = SampleUniformSphere(uDirection);
        emitted.p = p_;
        emitted.pdfPosition = 1;
        emitted.pdfDirection = PdfUniformSphere();
        return emitted;
    }
    EmissionDensity PdfLe(Normal3, Vec3) const override { return {1, PdfUniformSphere()}; }
    float Power() const override { return 4 * Pi * intensity_.luminance; }
    std::optional<LightBounds> Bounds() const override {
        LightBounds b;
        b.bounds = Bounds3(p_);
        b.power = Power();
        b.cosTheta_o = -1;
        return b;
    }

  private:
    Point3 p_;
    Emission intensity_;
};

std::unique_ptr<Light> CreatePoint(const LightArgs& args) {
    const Params& params = args.params;
    RequireInvertible(params, args.renderFromLight);
    Emission intensity = ReadEmission(params, "I", ReadScale(params));
    if (const float power = ReadQuantity(params, "power"); power > 0) {
        intensity.Scale(power / (4 * Pi));
        RequireFinite(params, "power", intensity.luminance);
    }
    const Point3 p = args.renderFromLight.Point(params.GetPoint3("from", Point3(0)));
    if (!IsFinite(p)) params.Fail("from", "the position of a light must be finite");
    return std::make_unique<PointLight>(p, std::move(intensity));
}

}  // namespace

LACQUER_REGISTER(LightKind, "point", CreatePoint);

}  // namespace lacquer
