// What lights share whose light comes from one point.
#pragma once

#include "pbrt/base/light.h"

namespace lacquer {

/// A light at one point. `Model`, the class that derives from this one, has
///   SampledSpectrum IntensityOver(Vec3 w, float distanceSquared, const SampledWavelengths& lambda) const
/// the radiant intensity toward w (unit, rendering space, away from the light) over the squared distance.
template <class Model>
class PointLikeLight : public Light {
  public:
    std::optional<LightSample> SampleLi(const LightReference& ref, Point2,
                                        const SampledWavelengths& lambda) const final {
        const Vec3 d = p_ - ref.p;
        const float distanceSquared = LengthSquared(d);
        if (!(distanceSquared > 0)) return std::nullopt;
        const Vec3 wi = d / std::sqrt(distanceSquared);
        const SampledSpectrum L =
            static_cast<const Model&>(*this).IntensityOver(-wi, distanceSquared, lambda);
        if (!L) return std::nullopt;
        return LightSample{L, wi, 1, p_, 0, Normal3(0)};
    }
    float PdfLi(const LightReference&, Vec3, const SurfaceInteraction*) const final { return 0; }
    std::optional<LightBounds> Bounds() const override { return AllAround(); }

  protected:
    /// @param p  in rendering space
    explicit PointLikeLight(Point3 p) : Light(Kind::DeltaPosition), p_(p) {}

    /// The bounds of a light that may shine anywhere.
    LightBounds AllAround() const {
        LightBounds b;
        b.bounds = Bounds3(p_);
        b.power = Power();
        b.cosTheta_o = -1;
        return b;
    }
    /// What SampleLe() gives for a direction w (unit, rendering space). Empty where nothing is emitted.
    std::optional<LightEmission> EmittedToward(Vec3 w, SampledSpectrum intensity, float pdfDirection) const {
        if (!intensity || !(pdfDirection > 0)) return std::nullopt;
        LightEmission emitted;
        emitted.L = intensity;
        emitted.p = p_;
        emitted.w = w;
        emitted.pdfPosition = 1;
        emitted.pdfDirection = pdfDirection;
        return emitted;
    }

    Point3 p_;
};

}  // namespace lacquer
