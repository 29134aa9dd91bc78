// Light "distant": parallel light from one direction, as from the sun.
//
//   "spectrum L"                the colour space's illuminant  irradiance on a surface that faces the light
//   "float scale"               1                              multiplies the emission, >= 0
//   "point3 from", "point3 to"  (0 0 0), (0 0 1)               the light travels from the one toward the
//                                                              other
//   "float illuminance"         not given                      if > 0, scales the light to this illuminance
//                                                              of a surface that faces it
#include "pbrt/core/invertible.h"
#include "pbrt/core/registry.h"
#include "pbrt/lights/emission.h"

namespace lacquer {

namespace {

class DistantLight final : public Light {
  public:
    /// @param w  unit, toward the light    @param irradiance  on a surface that faces the light
    DistantLight(Vec3 w, Emission irradiance)
        : Light(Kind::DeltaDirection), w_(w), irradiance_(std::move(irradiance)) {}

    void Preprocess(const Bounds3& sceneBounds) override { sceneSphere_ = BoundingSphereOf(sceneBounds); }
    std::optional<LightSample> SampleLi(const LightReference& ref, Point2,
                                        const SampledWavelengths& lambda) const override {
        const SampledSpectrum L = irradiance_.Sample(lambda);
        if (!L) return std::nullopt;
        return LightSample{L, w_, 1, ref.p + 2 * sceneSphere_.radius * w_, 0, Normal3(0)};
    }
    float PdfLi(const LightReference&, Vec3, const SurfaceInteraction*) const override { return 0; }
    std::optional<LightEmission> SampleLe(Point2 uPosition, Point2,
                                          const SampledWavelengths& lambda) const override {
        const SampledSpectrum L = irradiance_.Sample(lambda);
        if (!L) return std::nullopt;
        return EmissionThroughSphere(sceneSphere_, -w_, L, uPosition, 1);
    }
    EmissionDensity PdfLe(Normal3, Vec3) const override { return {PdfThroughSphere(sceneSphere_), 1}; }
    float Power() const override { return irradiance_.luminance * Pi * Sqr(sceneSphere_.radius); }

  private:
    Vec3 w_;
    Emission irradiance_;
    BoundingSphere sceneSphere_;
};

std::unique_ptr<Light> CreateDistant(const LightArgs& args) {
    const Params& params = args.params;
    RequireInvertible(params, args.renderFromLight);
    Emission irradiance = ReadEmission(params, "L", ReadScale(params));
    if (const float illuminance = ReadQuantity(params, "illuminance"); illuminance > 0) {
        irradiance.Scale(illuminance);
        RequireFinite(params, "illuminance", irradiance.luminance);
    }
    const Point3 from = params.GetPoint3("from", Point3(0)), to = params.GetPoint3("to", Point3(0, 0, 1));
    const Vec3 travel = ReadDirection(params, from, to);
    const Vec3 w = Normalize(args.renderFromLight.Vector(-travel));
    if (!IsFinite(w)) params.Fail("to", "the direction of the light must be finite after the transformation");
    return std::make_unique<DistantLight>(w, std::move(irradiance));
}

}  // namespace

LACQUER_REGISTER(LightKind, "distant", CreateDistant);

}  // namespace lacquer
