// Light "example": a point at the origin of the light's space.
// Stands in src/pbrt/lights. Scene: LightSource "example"
#include "pbrt/core/registry.h"
#include "pbrt/core/sampling.h"
#include "pbrt/lights/point_like.h"

namespace lacquer {
namespace {

class Example final : public PointLikeLight<Example> {
  public:
    explicit Example(Point3 p) : PointLikeLight(p) {}
    SampledSpectrum IntensityOver(Vec3, float distanceSquared, const SampledWavelengths&) const {
        return SampledSpectrum(1 / distanceSquared);
    }
    std::optional<LightEmission> SampleLe(Point2, Point2 uDirection,
                                          const SampledWavelengths&) const override {
        return EmittedToward(SampleUniformSphere(uDirection), SampledSpectrum(1), PdfUniformSphere());
    }
    EmissionDensity PdfLe(Normal3, Vec3) const override { return {1, PdfUniformSphere()}; }
    float Power() const override { return 4 * Pi; }
};

std::unique_ptr<Light> Create(const LightArgs& args) {
    return std::make_unique<Example>(args.renderFromLight.Point(Point3(0)));
}

}  // namespace

LACQUER_REGISTER(LightKind, "example", Create);

}  // namespace lacquer
