// Shape "cylinder": about the z axis, without caps.
//
//   "float radius"              1      > 0
//   "float zmin", "float zmax"  -1, 1  heights of its ends
//   "float phimax"              360    sweep angle about the z axis, > 0 [degrees]
#include <fmt/format.h>

#include "pbrt/shapes/quadric.h"

namespace lacquer {

namespace {

class Cylinder final : public Quadric {
  public:
    Cylinder(const Transform& renderFromObject, bool reverseOrientation, double radius, double zMin,
             double zMax, double phiMax)
        : Quadric(renderFromObject, reverseOrientation, phiMax), radius_(radius), zMin_(zMin), zMax_(zMax) {}

  protected:
    Bounds3 ObjectBounds() const override {
        const float r = float(radius_);
        return {{-r, -r, float(zMin_)}, {r, r, float(zMax_)}};
    }
    double ObjectArea() const override { return phiMax_ * radius_ * (zMax_ - zMin_); }
    std::optional<double> IntersectLocal(const LocalRay& ray, double tMin, double tMax) const override;
    LocalPoint PointAt(glm::dvec3 p, bool wantsUv) const override;
    glm::dvec3 SamplePoint(Point2 u) const override {
        const double phi = double(u.y) * phiMax_;
        return {radius_ * std::cos(phi), radius_ * std::sin(phi), zMin_ + double(u.x) * (zMax_ - zMin_)};
    }

  private:
    double radius_, zMin_, zMax_;
};

std::optional<double> Cylinder::IntersectLocal(const LocalRay& ray, double tMin, double tMax) const {
    // As for a sphere, but in the xy plane; rays along the axis never meet the mantle.
    const glm::dvec2 o(ray.o), d(ray.d);
    const double dd = glm::dot(d, d);
    if (!(dd > 0)) return std::nullopt;
    const double tNearest = -glm::dot(o, d) / dd;
    const glm::dvec2 nearest = o + tNearest * d;
    const double chord2 = (radius_ * radius_ - glm::dot(nearest, nearest)) / dd;
    if (!(chord2 >= 0)) return std::nullopt;
    const double halfChord = std::sqrt(chord2);
    for (const double t : {tNearest - halfChord, tNearest + halfChord}) {
        const glm::dvec3 p = ray.o + t * ray.d;
        if (t > tMin && t < tMax && p.z >= zMin_ && p.z <= zMax_ && InSweep(p)) return t;
    }
    return std::nullopt;
}

Quadric::LocalPoint Cylinder::PointAt(glm::dvec3 p, bool wantsUv) const {
    LocalPoint point;
    point.n = Radial(p);
    point.p = radius_ * point.n + glm::dvec3(0, 0, std::clamp(p.z, zMin_, zMax_));
    if (!wantsUv) return point;
    point.dndu = phiMax_ * glm::dvec3(-point.n.y, point.n.x, 0);
    point.dpdu = radius_ * point.dndu;
    point.dpdv = glm::dvec3(0, 0, zMax_ - zMin_);
    point.uv = BoundUv(SweepShare(point.p), (point.p.z - zMin_) / (zMax_ - zMin_));
    return point;
}

std::vector<std::unique_ptr<Shape>> CreateCylinder(const ShapeArgs& args) {
    const Params& params = args.params;
    const float radius = GetPositiveFloat(params, "radius", 1);
    const float z0 = GetFiniteFloat(params, "zmin", -1), z1 = GetFiniteFloat(params, "zmax", 1);
    const double phiMax = GetPhiMax(params);
    if (z0 == z1)
        params.Fail("zmin",
                    fmt::format("\"zmin\" and \"zmax\" are both {}; two different heights are expected", z0));
    auto cylinder = std::make_unique<Cylinder>(args.renderFromObject, args.reverseOrientation, double(radius),
                                               double(std::min(z0, z1)), double(std::max(z0, z1)), phiMax);
    return FinishQuadric(params, std::move(cylinder));
}

}  // namespace

LACQUER_REGISTER(ShapeKind, "cylinder", CreateCylinder);

}  // namespace lacquer
