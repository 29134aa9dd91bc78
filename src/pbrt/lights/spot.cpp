// Light "spot": from one point into a cone with a soft rim.
//
//   "spectrum I"                the colour space's illuminant  intensity on the axis
//   "float scale"               1                              multiplies the emission, >= 0
//   "point3 from", "point3 to"  (0 0 0), (0 0 1)               the axis of the cone
//   "float coneangle"           30                             half angle beyond which there is no light
//                                                              [degrees]
//   "float conedeltaangle"      5                              width of the fall-off inside of it [degrees]
//   "float power"               not given                      if > 0, scales the light to this total power
#include <fmt/format.h>

#include "pbrt/core/invertible.h"
#include "pbrt/core/registry.h"
#include "pbrt/core/sampling.h"
#include "pbrt/lights/emission.h"
#include "pbrt/lights/point_like.h"

namespace lacquer {

namespace {

/// Intensity falls off between two cosines of the angle with the axis, a < b: SmoothStep(cos, a, b).
struct Falloff {
    float a = 0, b = 1;
    float operator()(float cosTheta) const { return SmoothStep(cosTheta, a, b); }
    /// Integral over the sphere: SmoothStep has the mean 1/2 over [a, b].
    float Integral() const { return 2 * Pi * ((1 - b) + (b - a) / 2); }
};

class SpotLight final : public PointLikeLight<SpotLight> {
  public:
    /// @param axis  unit, in the light's space
    SpotLight(const Transform& renderFromLight, Point3 from, Vec3 axis, Falloff falloff, Emission intensity)
        : PointLikeLight(renderFromLight.Point(from)),
          renderFromLight_(renderFromLight),
          solidAngles_(renderFromLight),
          axis_(axis),
          falloff_(falloff),
          intensity_(std::move(intensity)) {}

    SampledSpectrum IntensityOver(Vec3 w, float distanceSquared, const SampledWavelengths& lambda) const {
        // The cone is one of the light's own space: a transform that squeezes space squeezes it too.
        const float weight = falloff_(Dot(axis_, Normalize(renderFromLight_.InverseVector(w))));
        if (!(weight > 0)) return SampledSpectrum(0);
        return intensity_.Sample(lambda) * (weight / distanceSquared);
    }
    // Uniform in the cone.
    std::optional<LightEmission> SampleLe(Point2, Point2 uDirection,
                                          const SampledWavelengths& lambda) const override {
        const Vec3 local = Frame::FromZ(axis_).FromLocal(SampleUniformCone(uDirection, falloff_.a));
        return EmittedToward(Normalize(renderFromLight_.Vector(local)),
                             intensity_.Sample(lambda) * falloff_(Dot(axis_, local)),
                             PdfUniformCone(1 - falloff_.a) * solidAngles_.DensityFactor(local));
    }
    EmissionDensity PdfLe(Normal3, Vec3 w) const override {
        const Vec3 local = Normalize(renderFromLight_.InverseVector(w));
        if (!(Dot(axis_, local) > falloff_.a)) return {1, 0};
        return {1, PdfUniformCone(1 - falloff_.a) * solidAngles_.DensityFactor(local)};
    }
    float Power() const override { return intensity_.luminance * falloff_.Integral(); }
    std::optional<LightBounds> Bounds() const override;

  private:
    bool KeepsAngles() const;

    Transform renderFromLight_;
    SolidAngleMap solidAngles_;
    Vec3 axis_;
    Falloff falloff_;
    Emission intensity_;
};

bool SpotLight::KeepsAngles() const {
    const glm::mat3 m(renderFromLight_.Matrix());
    const glm::mat3 gram = glm::transpose(m) * m;
    const float size = gram[0][0];
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r)
            if (!(std::abs(gram[c][r] - (c == r ? size : 0.f)) <= 1e-3f * size)) return false;
    return true;
}

std::optional<LightBounds> SpotLight::Bounds() const {
    LightBounds b = AllAround();
    if (!KeepsAngles()) return b;
    // Emission within theta_o counts in full and falls like a cosine over the next theta_e, which therefore
    // must stay well below a right angle; a hundredth of a radian covers the rounding at the rim.
    constexpr float kLongestFall = Pi / 3, kMargin = 0.01f;
    const float rim = SafeACos(falloff_.a);
    const float theta_o = std::max(SafeACos(falloff_.b), rim - kLongestFall);
    b.axis = Normalize(renderFromLight_.Vector(axis_));
    b.cosTheta_o = std::cos(theta_o);
    b.cosTheta_e = std::cos(rim - theta_o + kMargin);
    return b;
}

std::unique_ptr<Light> CreateSpot(const LightArgs& args) {
    const Params& params = args.params;
    RequireInvertible(params, args.renderFromLight);
    Emission intensity = ReadEmission(params, "I", ReadScale(params));

    // The cone: half angles. A fall-off wider than twice the cone has its start outside of the cone: no
    // fall-off.
    const float cone = params.GetFloat("coneangle", 30), delta = params.GetFloat("conedeltaangle", 5);
    if (!(cone > 0 && cone <= 180))
        params.Fail("coneangle",
                    fmt::format("expected a half angle above 0 and up to 180 degrees, found {}", cone));
    if (!(delta >= 0 && delta <= 180))
        params.Fail("conedeltaangle",
                    fmt::format("expected an angle from 0 to 180 degrees, found {}", delta));
    Falloff falloff;
    falloff.a = std::cos(Radians(cone));
    falloff.b = std::max(falloff.a, std::cos(Radians(cone - delta)));

    if (const float power = ReadQuantity(params, "power"); power > 0) {
        intensity.Scale(power / falloff.Integral());
        RequireFinite(params, "power", intensity.luminance);
    }
    const Point3 from = params.GetPoint3("from", Point3(0));
    const Vec3 axis = ReadDirection(params, from, params.GetPoint3("to", Point3(0, 0, 1)));
    if (!IsFinite(args.renderFromLight.Point(from)))
        params.Fail("from", "the position of a light must be finite");
    return std::make_unique<SpotLight>(args.renderFromLight, from, axis, falloff, std::move(intensity));
}

}  // namespace

LACQUER_REGISTER(LightKind, "spot", CreateSpot);

}  // namespace lacquer
