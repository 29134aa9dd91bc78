// What spheres, cylinders and disks share: surfaces of revolution about the z axis of object space, with
// u = phi / phimax from +x toward +y.
#pragma once

#include <glm/vec3.hpp>
#include <optional>

#include "pbrt/base/shape.h"

namespace lacquer {

/// A quadric in object space. The arithmetic is in double, so that the only error of a point is the rounding
/// of its rendering-space coordinates to float.
class Quadric : public Shape {
  public:
    Bounds3 Bounds(int primitive) const final;
    std::optional<ShapeHit> Intersect(const Ray& ray, float tMin, float tMax, int primitive) const final;
    void Interaction(const Ray& ray, const ShapeHit& hit, int primitive, SurfaceInteraction* si) const final;
    /// In object space, as pbrt (3.8 of the format: emitters under a scaling transform keep that area).
    float Area(int /*primitive*/) const final { return float(ObjectArea()); }
    std::optional<ShapeSample> SampleArea(int primitive, Point2 u) const final;
    std::optional<ShapeSample> SampleSolidAngle(int primitive, const LightReference& ref, Point2 u,
                                                bool wantsUv) const override;
    /// By area. Unlike Area(), densities are those of the transformed surface, so that scaled emitters stay
    /// unbiased.
    float PdfSolidAngle(int primitive, const LightReference& ref, Point3 p, Normal3 n) const override;
    size_t MemoryBytes() const override { return sizeof(*this); }

  protected:
    struct LocalRay {
        glm::dvec3 o, d;
    };
    /// A point of the surface with its derivatives; n is unit and along dpdu x dpdv.
    struct LocalPoint {
        glm::dvec3 p{0}, dpdu{0}, dpdv{0};
        glm::dvec3 n{0}, dndu{0}, dndv{0};
        Point2 uv{0};  ///< by BoundUv()
    };

    Quadric(const Transform& renderFromObject, bool reverseOrientation, double phiMax);

    /// Box around the (trimmed) surface in object space.
    virtual Bounds3 ObjectBounds() const = 0;
    virtual double ObjectArea() const = 0;
    /// Nearest t with tMin < t < tMax.
    virtual std::optional<double> IntersectLocal(const LocalRay& ray, double tMin, double tMax) const = 0;
    /// The surface point nearest to p, which lies on the surface up to rounding.
    /// @param wantsUv  false: uv and derivatives may be left out
    virtual LocalPoint PointAt(glm::dvec3 p, bool wantsUv) const = 0;
    /// A point of the untrimmed (sphere, disk) or trimmed (cylinder) surface, uniform by area.
    virtual glm::dvec3 SamplePoint(Point2 u) const = 0;

    /// Points of the part that was trimmed away lie outside [0,1]^2, by how much depends on a slim sector or
    /// zone.
    static Point2 BoundUv(double u, double v) {
        return Point2(std::clamp(u, -1e6, 1e6), std::clamp(v, -1e6, 1e6));
    }
    /// Whether the sweep angle lets p through.
    bool InSweep(glm::dvec3 p) const;
    /// Azimuth of p over the sweep angle, to float precision: the parameter u.
    double SweepShare(glm::dvec3 p) const;
    /// Unit radial direction of p in the xy plane; +x on the axis.
    static glm::dvec3 Radial(glm::dvec3 p);

    glm::dvec3 ToRender(glm::dvec3 p) const { return linear_ * p + translation_; }
    glm::dvec3 ToObject(glm::dvec3 p) const { return VectorToObject(p - translation_); }
    glm::dvec3 VectorToObject(glm::dvec3 v) const { return inverseLinear_ * v; }
    /// Of a point that was computed in double. One rounding to float makes half a unit in the last place;
    /// four units leave room for the offset's own rounding.
    static float ErrorBound(Point3 p) { return 8 * MachineEpsilon * MaxComponent(Abs(p)); }
    /// -1 where a transformed object-space normal is to be turned around.
    double NormalSign() const { return (determinant_ < 0) != reverseOrientation_ ? -1. : 1.; }
    /// The sample record of a surface point: oriented normal, uv, and the density by area after the
    /// transform.
    ShapeSample SampleAt(glm::dvec3 p, bool wantsUv) const;
    /// The largest factor by which a length grows from object to rendering space, where it is the same in all
    /// directions up to rounding; 0 if it is not.
    double UniformScale() const { return uniformScale_; }

    double phiMax_;
    bool fullSweep_;

  private:
    /// Area after the transform of a unit of area with object-space normal n.
    double AreaScale(glm::dvec3 n) const;

    glm::dmat3 linear_, inverseLinear_, normalMatrix_;
    glm::dvec3 translation_;
    double determinant_, uniformScale_;
    bool reverseOrientation_;
};

/// The result of a quadric's factory. Errors: SceneError if the transformed quadric does not fit into floats.
std::vector<std::unique_ptr<Shape>> FinishQuadric(const Params& params, std::unique_ptr<Quadric> quadric);
/// `phimax` of a quadric in radians. Errors: SceneError unless it is above 0; more than 360 means a full
/// turn.
double GetPhiMax(const Params& params);
/// A finite float. Errors: SceneError for NaN and infinities.
float GetFiniteFloat(const Params& params, std::string_view name, float fallback);
/// A finite float above 0.
float GetPositiveFloat(const Params& params, std::string_view name, float fallback);

}  // namespace lacquer
