// Shape "disk": in the plane z = height, perhaps with a hole or as a sector. As an emitter the whole disk is
// sampled, as in pbrt.
//
//   "float height"       0
//   "float radius"       1    > 0
//   "float innerradius"  0    of the hole
//   "float phimax"       360  sweep angle about the z axis, > 0 [degrees]
#include <fmt/format.h>

#include "pbrt/core/sampling.h"
#include "pbrt/shapes/quadric.h"

namespace lacquer {

namespace {

class Disk final : public Quadric {
  public:
    Disk(const Transform& renderFromObject, bool reverseOrientation, double height, double radius,
         double innerRadius, double phiMax)
        : Quadric(renderFromObject, reverseOrientation, phiMax),
          height_(height),
          radius_(radius),
          innerRadius_(innerRadius) {}

    std::pair<Vec3, float> NormalCone(int primitive) const override {
        return {SampleArea(primitive, {0.5f, 0.5f}).value_or(ShapeSample{}).n, 1.f};
    }

  protected:
    Bounds3 ObjectBounds() const override {
        const float r = float(radius_), h = float(height_);
        return {{-r, -r, h}, {r, r, h}};
    }
    double ObjectArea() const override {
        return phiMax_ / 2 * (radius_ * radius_ - innerRadius_ * innerRadius_);
    }
    std::optional<double> IntersectLocal(const LocalRay& ray, double tMin, double tMax) const override;
    LocalPoint PointAt(glm::dvec3 p, bool wantsUv) const override;
    glm::dvec3 SamplePoint(Point2 u) const override {
        const Point2 d = SampleUniformDiskConcentric(u);
        return {radius_ * double(d.x), radius_ * double(d.y), height_};
    }

  private:
    double height_, radius_, innerRadius_;
};

std::optional<double> Disk::IntersectLocal(const LocalRay& ray, double tMin, double tMax) const {
    if (ray.d.z == 0) return std::nullopt;
    const double t = (height_ - ray.o.z) / ray.d.z;
    if (!(t > tMin && t < tMax)) return std::nullopt;
    const glm::dvec3 p = ray.o + t * ray.d;
    const double r2 = p.x * p.x + p.y * p.y;
    if (r2 > radius_ * radius_ || r2 < innerRadius_ * innerRadius_ || !InSweep(p)) return std::nullopt;
    return t;
}

Quadric::LocalPoint Disk::PointAt(glm::dvec3 p, bool wantsUv) const {
    LocalPoint point;
    point.p = glm::dvec3(p.x, p.y, height_);
    point.n = glm::dvec3(0, 0, 1);
    if (!wantsUv) return point;
    // At the centre, where dpdu vanishes, the tangent of a point close by.
    const glm::dvec3 radial = Radial(p);
    const double r = std::sqrt(p.x * p.x + p.y * p.y);
    point.dpdu = phiMax_ * std::max(r, 1e-5 * radius_) * glm::dvec3(-radial.y, radial.x, 0);
    point.dpdv = (innerRadius_ - radius_) * radial;
    point.uv = BoundUv(SweepShare(p), (radius_ - r) / (radius_ - innerRadius_));
    return point;
}

std::vector<std::unique_ptr<Shape>> CreateDisk(const ShapeArgs& args) {
    const Params& params = args.params;
    const float height = GetFiniteFloat(params, "height", 0);
    const float radius = GetPositiveFloat(params, "radius", 1);
    const float innerRadius = GetFiniteFloat(params, "innerradius", 0);
    const double phiMax = GetPhiMax(params);
    if (innerRadius < 0 || innerRadius >= radius)
        params.Fail("innerradius",
                    fmt::format("\"innerradius\" is {}; at least 0 and less than the radius, {}, is "
                                "expected",
                                innerRadius, radius));
    auto disk = std::make_unique<Disk>(args.renderFromObject, args.reverseOrientation, double(height),
                                       double(radius), double(innerRadius), phiMax);
    return FinishQuadric(params, std::move(disk));
}

}  // namespace

LACQUER_REGISTER(ShapeKind, "disk", CreateDisk);

}  // namespace lacquer
