// Light "point": from one point, the same in all directions.
//
//   "spectrum I"   the colour space's illuminant  intensity
//   "float scale"  1                              multiplies the emission, >= 0
//   "float power"  not given                      if > 0, scales the light to this total power
//   "point3 from"  0 0 0                          its position
#include "pbrt/core/invertible.h"
#include "pbrt/core/registry.h"
#include "pbrt/core/sampling.h"
#include "pbrt/lights/emission.h"
#include "pbrt/lights/point_like.h"

namespace lacquer {

namespace {

class PointLight final : public PointLikeLight<PointLight> {
  public:
    PointLight(Point3 p, Emission intensity) : PointLikeLight(p), intensity_(std::move(intensity)) {}

    SampledSpectrum IntensityOver(Vec3, float distanceSquared, const SampledWavelengths& lambda) const {
        return intensity_.Sample(lambda) / distanceSquared;
    }
    std::optional<LightEmission> SampleLe(Point2, Point2 uDirection,
                                          const SampledWavelengths& lambda) const override {
        return EmittedToward(SampleUniformSphere(uDirection), intensity_.Sample(lambda), PdfUniformSphere());
    }
    EmissionDensity PdfLe(Normal3, Vec3) const override { return {1, PdfUniformSphere()}; }
    float Power() const override { return 4 * Pi * intensity_.luminance; }

  private:
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
