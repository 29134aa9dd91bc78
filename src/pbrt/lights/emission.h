// What the light sources of a scene file have in common: their spectrum, its scale, and the units of both.
#pragma once

#include <memory>
#include <string_view>

#include "pbrt/base/light.h"
#include "pbrt/core/spectrum.h"

namespace lacquer {

/// Emission of a light, for fast look-ups and in few bytes: a scene may have millions of lights. Colours are
/// their polynomials, other spectra are tables, which lights of equal spectra share.
struct Emission {
    std::shared_ptr<const Spectrum> spectrum;  ///< before the scale
    float scale = 1;
    float luminance = 0;  ///< sum over integer nm of y(lambda) Sample(lambda)

    SampledSpectrum Sample(const SampledWavelengths& lambda) const {
        return spectrum->Sample(lambda) * scale;
    }
    /// Largest value (an upper bound).
    float MaxValue() const { return spectrum->MaxValue() * scale; }
    void Scale(float s) {
        scale *= s;
        luminance *= s;
    }
};

/// The spectrum under `parameter`, or the colour space's illuminant, times EmissionScale() for `scale`.
/// Errors: SceneError if the spectrum has no luminance or the product is not finite.
Emission ReadEmission(const Params& params, std::string_view parameter, float scale);

/// `"float scale"`, 1 if absent. Errors: SceneError unless it is finite and not negative.
float ReadScale(const Params& params);

/// `"float name"` of a power or an illuminance; 0, which means "not given", if it is absent or not positive.
/// Errors: SceneError if it is not finite.
float ReadQuantity(const Params& params, std::string_view name);

/// `value` if it is finite. Errors: SceneError at `parameter` otherwise.
float RequireFinite(const Params& params, std::string_view parameter, float value);

/// Unit direction from the parameter `from` to the parameter `to` in the light's space.
/// Errors: SceneError if the points coincide or are not finite.
Vec3 ReadDirection(const Params& params, Point3 from, Point3 to);

/// Bounding sphere of everything that rays can hit; a unit sphere where that is nothing.
struct BoundingSphere {
    Point3 center{0};
    float radius = 1;
};
BoundingSphere BoundingSphereOf(const Bounds3& sceneBounds);

/// Light that arrives in the scene along w, from a uniform point of the disk across w that covers the
/// bounding sphere.
/// @param pdfDirection  of w [1/sr]
LightEmission EmissionThroughSphere(const BoundingSphere& sphere, Vec3 w, SampledSpectrum L, Point2 u,
                                    float pdfDirection);
inline float PdfThroughSphere(const BoundingSphere& sphere) { return 1 / (Pi * Sqr(sphere.radius)); }

/// Quotient of densities over solid angle: around M w, where w is unit, to around w. A matrix takes the solid
/// angle around a unit vector w to |det M| / |M w|^3 of it.
class SolidAngleMap {
  public:
    explicit SolidAngleMap(const Transform& t)
        : m_(t.Matrix()), determinant_(float(std::abs(glm::determinant(glm::dmat3(m_))))) {}
    /// @param w  unit, before the map
    float DensityFactor(Vec3 w) const {
        const float length = Length(m_ * w);
        return length * length * length / determinant_;
    }

  private:
    glm::mat3 m_;
    float determinant_;
};

}  // namespace lacquer
