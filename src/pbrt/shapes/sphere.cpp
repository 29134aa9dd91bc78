// Shape "sphere": about the origin, trimmed by z and phi. As an emitter the whole sphere is sampled, as in
// pbrt.
//
//   "float radius"              1                > 0
//   "float zmin", "float zmax"  -radius, radius  heights at which it is cut off
//   "float phimax"              360              sweep angle about the z axis, > 0 [degrees]
#include <fmt/format.h>

#include "pbrt/core/sampling.h"
#include "pbrt/core/special_functions.h"
#include "pbrt/shapes/quadric.h"

namespace lacquer {

namespace {

class Sphere final : public Quadric {
  public:
    Sphere(const Transform& renderFromObject, bool reverseOrientation, double radius, double zMin,
           double zMax, double phiMax)
        : Quadric(renderFromObject, reverseOrientation, phiMax),
          radius_(radius),
          zMin_(zMin),
          zMax_(zMax),
          thetaMin_(std::acos(std::clamp(zMin / radius, -1., 1.))),
          thetaMax_(std::acos(std::clamp(zMax / radius, -1., 1.))),
          center_(ToRender(glm::dvec3(0))) {}

    std::optional<ShapeSample> SampleSolidAngle(int primitive, const LightReference& ref, Point2 u,
                                                bool wantsUv) const override;
    float PdfSolidAngle(int primitive, const LightReference& ref, Point3 p, Normal3 n) const override;

  protected:
    Bounds3 ObjectBounds() const override {
        const float r = float(radius_);
        return {{-r, -r, float(zMin_)}, {r, r, float(zMax_)}};
    }
    double ObjectArea() const override { return phiMax_ * radius_ * (zMax_ - zMin_); }
    std::optional<double> IntersectLocal(const LocalRay& ray, double tMin, double tMax) const override;
    LocalPoint PointAt(glm::dvec3 p, bool wantsUv) const override;
    glm::dvec3 SamplePoint(Point2 u) const override { return radius_ * glm::dvec3(SampleUniformSphere(u)); }

  private:
    /// The cone in which a reference point sees the sphere.
    struct Cone {
        glm::dvec3 axis;  ///< from the centre to the reference point, unit
        float onePlusCosThetaMax, oneMinusCosThetaMax, cos2ThetaMax;
    };
    /// Empty inside, and where the transform makes the sphere an ellipsoid.
    std::optional<Cone> ConeFrom(const LightReference& ref) const;
    bool InTrim(glm::dvec3 p) const {
        return (zMin_ <= -radius_ || p.z >= zMin_) && (zMax_ >= radius_ || p.z <= zMax_) && InSweep(p);
    }

    Point2 UvAt(glm::dvec3 p) const;

    double radius_, zMin_, zMax_;
    double thetaMin_, thetaMax_;  // polar angles at zmin and zmax
    glm::dvec3 center_;           // in rendering space
};

std::optional<double> Sphere::IntersectLocal(const LocalRay& ray, double tMin, double tMax) const {
    // From the point of the ray next to the centre, half a chord to each side.
    const double dd = glm::dot(ray.d, ray.d);
    const double tNearest = -glm::dot(ray.o, ray.d) / dd;
    const glm::dvec3 nearest = ray.o + tNearest * ray.d;
    const double chord2 = (radius_ * radius_ - glm::dot(nearest, nearest)) / dd;
    if (!(chord2 >= 0)) return std::nullopt;
    const double halfChord = std::sqrt(chord2);
    for (const double t : {tNearest - halfChord, tNearest + halfChord})
        if (t > tMin && t < tMax && InTrim(ray.o + t * ray.d)) return t;
    return std::nullopt;
}

Quadric::LocalPoint Sphere::PointAt(glm::dvec3 p, bool wantsUv) const {
    LocalPoint point;
    const double length = glm::length(p);
    point.p = length > 0 ? p * (radius_ / length) : glm::dvec3(0, 0, radius_);
    point.n = point.p / radius_;
    if (!wantsUv) return point;

    // Tangents; at the poles, where dpdu vanishes, those of a point close by.
    const glm::dvec3 radial = Radial(point.p);
    const double axisDistance =
        std::max(std::sqrt(point.p.x * point.p.x + point.p.y * point.p.y), 1e-5 * radius_);
    const double sweep = thetaMax_ - thetaMin_;
    point.dpdu = phiMax_ * axisDistance * glm::dvec3(-radial.y, radial.x, 0);
    point.dpdv = sweep * glm::dvec3(point.p.z * radial.x, point.p.z * radial.y, -axisDistance);
    point.dndu = point.dpdu / radius_;
    point.dndv = point.dpdv / radius_;
    point.uv = UvAt(point.p);
    return point;
}

Point2 Sphere::UvAt(glm::dvec3 p) const {
    // Arc tangents of floats keep their digits everywhere, unlike an arc cosine near the poles.
    const double theta = double(ATan2(float(std::sqrt(p.x * p.x + p.y * p.y)), float(p.z)));
    return BoundUv(SweepShare(p), (theta - thetaMin_) / (thetaMax_ - thetaMin_));
}

std::optional<Sphere::Cone> Sphere::ConeFrom(const LightReference& ref) const {
    const double scale = UniformScale();
    if (scale == 0) return std::nullopt;
    // A reference point on the sphere itself counts to the side that its surface leaves it on.
    const Point3 origin = OffsetRayOrigin(ref.p, ref.pError, ref.n, Vec3(center_ - glm::dvec3(ref.p)));
    const glm::dvec3 outward = glm::dvec3(origin) - center_;
    const double radius2 = Sqr(radius_ * scale), distance2 = glm::dot(outward, outward);
    if (!(distance2 > radius2)) return std::nullopt;
    // In double only what floats would cancel or overflow: sin^2 and cos^2 are right to their last digits.
    const double inverse = 1 / distance2;
    const float sin2 = float(radius2 * inverse), cos2 = float((distance2 - radius2) * inverse);
    // 1 - cos = sin^2 / (1 + cos) keeps its digits in narrow cones.
    const float onePlusCos = 1 + std::sqrt(cos2);
    return Cone{outward * std::sqrt(inverse), onePlusCos, sin2 / onePlusCos, cos2};
}

std::optional<ShapeSample> Sphere::SampleSolidAngle(int primitive, const LightReference& ref, Point2 u,
                                                    bool wantsUv) const {
    const std::optional<Cone> cone = ConeFrom(ref);
    if (!cone) return Quadric::SampleSolidAngle(primitive, ref, u, wantsUv);

    // Draw an angle theta in the cone, stably: x = 1 - cos theta, sin^2 theta = x (2 - x).
    const float x = u.x * cone->oneMinusCosThetaMax;
    const float sinTheta = std::sqrt(x * (2 - x)), cosTheta = 1 - x;

    // The line at theta meets the sphere under beta with the normal, sin beta = sin theta / sin thetaMax, and
    // seen from the centre the point lies at alpha = beta - theta off the axis.
    const float sin2Beta = std::min(u.x * (2 - x) / cone->onePlusCosThetaMax, 1.f);
    const float sinBeta = std::sqrt(sin2Beta), cosBeta = std::sqrt(1 - sin2Beta);
    // sin alpha = sin(beta - theta) without its difference, which would lose all digits next to the sphere:
    // (sin^2 beta - sin^2 theta) / sin(beta + theta), where sin^2 theta = sin^2 beta sin^2 thetaMax.
    const float sinSum = sinBeta * cosTheta + cosBeta * sinTheta;
    const float sinAlpha = sinSum > 0 ? sin2Beta * cone->cos2ThetaMax / sinSum : 0.f;
    const float cosAlpha = cosBeta * cosTheta + sinBeta * sinTheta;
    const Frame frame = Frame::FromZ(Vec3(cone->axis));
    const auto [sinPhi, cosPhi] = SinCosOfTurn(u.y);
    glm::dvec3 n =
        glm::dvec3(sinAlpha * (cosPhi * frame.x + sinPhi * frame.y)) + double(cosAlpha) * cone->axis;
    n *= (3 - glm::dot(n, n)) / 2;  // a Newton step to unit length: sines and frame are right to floats

    ShapeSample sample;
    const double radius = radius_ * UniformScale();
    const glm::dvec3 fromCenter = radius * n;
    sample.p = Point3(center_ + fromCenter);
    sample.pError = ErrorBound(sample.p);
    sample.n = Normal3(n * NormalSign());
    if (wantsUv) sample.uv = UvAt(VectorToObject(fromCenter));
    sample.pdf = PdfUniformCone(cone->oneMinusCosThetaMax);
    if (!std::isfinite(sample.pdf)) return std::nullopt;
    return sample;
}

float Sphere::PdfSolidAngle(int primitive, const LightReference& ref, Point3 p, Normal3 n) const {
    const std::optional<Cone> cone = ConeFrom(ref);
    if (!cone) return Quadric::PdfSolidAngle(primitive, ref, p, n);
    const float pdf = PdfUniformCone(cone->oneMinusCosThetaMax);
    return std::isfinite(pdf) ? pdf : 0.f;
}

std::vector<std::unique_ptr<Shape>> CreateSphere(const ShapeArgs& args) {
    const Params& params = args.params;
    const float radius = GetPositiveFloat(params, "radius", 1);
    const float z0 = std::clamp(GetFiniteFloat(params, "zmin", -radius), -radius, radius);
    const float z1 = std::clamp(GetFiniteFloat(params, "zmax", radius), -radius, radius);
    const double phiMax = GetPhiMax(params);
    if (z0 == z1)
        params.Fail("zmin",
                    fmt::format("nothing is left of the sphere between \"zmin\" and \"zmax\", both {} after "
                                "clamping to its radius; two different heights are expected",
                                z0));
    auto sphere = std::make_unique<Sphere>(args.renderFromObject, args.reverseOrientation, double(radius),
                                           double(std::min(z0, z1)), double(std::max(z0, z1)), phiMax);
    return FinishQuadric(params, std::move(sphere));
}

}  // namespace

LACQUER_REGISTER(ShapeKind, "sphere", CreateSphere);

}  // namespace lacquer
