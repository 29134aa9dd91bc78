#include "pbrt/shapes/quadric.h"

#include <fmt/format.h>

#include <glm/matrix.hpp>
#include <numbers>

namespace lacquer {

namespace {

constexpr double kPi = std::numbers::pi;

// Columns of equal length at right angles, up to the rounding of float matrices that were multiplied up.
double UniformScaleOf(const glm::dmat3& m) {
    const double xx = glm::dot(m[0], m[0]), yy = glm::dot(m[1], m[1]), zz = glm::dot(m[2], m[2]);
    const double tolerance = 1e-4 * xx;
    const bool equal = std::abs(yy - xx) < tolerance && std::abs(zz - xx) < tolerance;
    const bool orthogonal = std::abs(glm::dot(m[0], m[1])) < tolerance &&
                            std::abs(glm::dot(m[0], m[2])) < tolerance &&
                            std::abs(glm::dot(m[1], m[2])) < tolerance;
    return equal && orthogonal ? std::sqrt((xx + yy + zz) / 3) : 0.;
}

}  // namespace

// The inverse is made anew in double: the float one would add an error of its own to every ray.
Quadric::Quadric(const Transform& renderFromObject, bool reverseOrientation, double phiMax)
    : phiMax_(std::min(phiMax, 2 * kPi)),
      fullSweep_(phiMax >= 2 * kPi * (1 - 1e-7)),
      linear_(glm::mat3(renderFromObject.Matrix())),
      inverseLinear_(glm::inverse(linear_)),
      normalMatrix_(glm::transpose(inverseLinear_)),
      translation_(glm::vec3(renderFromObject.Matrix()[3])),
      determinant_(glm::determinant(linear_)),
      uniformScale_(UniformScaleOf(linear_)),
      reverseOrientation_(reverseOrientation) {}

bool Quadric::InSweep(glm::dvec3 p) const {
    if (fullSweep_) return true;
    const double phi = std::atan2(p.y, p.x);
    return (phi < 0 ? phi + 2 * kPi : phi) <= phiMax_;
}

double Quadric::SweepShare(glm::dvec3 p) const {
    const double phi = double(ATan2(float(p.y), float(p.x)));
    return (phi < 0 ? phi + 2 * kPi : phi) / phiMax_;
}

glm::dvec3 Quadric::Radial(glm::dvec3 p) {
    const double length = std::sqrt(p.x * p.x + p.y * p.y);
    return length > 0 ? glm::dvec3(p.x / length, p.y / length, 0) : glm::dvec3(1, 0, 0);
}

double Quadric::AreaScale(glm::dvec3 n) const {
    return std::abs(determinant_) * glm::length(normalMatrix_ * n);
}

Bounds3 Quadric::Bounds(int /*primitive*/) const {
    const Bounds3 local = ObjectBounds();
    Bounds3 bounds;
    for (int i = 0; i < 8; ++i) bounds = bounds.Union(Point3(ToRender(glm::dvec3(local.Corner(i)))));
    const Vec3 pad(2 * MachineEpsilon * MaxComponent(glm::max(Abs(bounds.min), Abs(bounds.max))));
    return {bounds.min - pad, bounds.max + pad};
}

std::optional<ShapeHit> Quadric::Intersect(const Ray& ray, float tMin, float tMax, int /*primitive*/) const {
    const LocalRay local{ToObject(glm::dvec3(ray.o)), inverseLinear_ * glm::dvec3(ray.d)};
    const std::optional<double> t = IntersectLocal(local, double(tMin), double(tMax));
    if (!t) return std::nullopt;
    const float rounded = float(*t);
    if (!(rounded > tMin && rounded < tMax)) return std::nullopt;
    return ShapeHit{rounded, Vec2(0)};
}

void Quadric::Interaction(const Ray& ray, const ShapeHit& hit, int /*primitive*/,
                          SurfaceInteraction* si) const {
    // Take the hit point back to the surface.
    const glm::dvec3 p = glm::dvec3(ray.o) + double(hit.t) * glm::dvec3(ray.d);
    const LocalPoint local = PointAt(ToObject(p), true);

    // The normal is that of dpdu x dpdv in object space, which a mirroring turns around; so is the cross
    // product of the transformed tangents, and only ReverseOrientation is left to apply.
    const glm::dvec3 bigN = normalMatrix_ * local.n;
    const double length = glm::length(bigN);
    const glm::dvec3 n = bigN / length;
    const double sign = NormalSign();
    const Point3 point(ToRender(local.p));
    si->time = ray.time;
    si->SetGeometry(point, ErrorBound(point), local.uv, Vec3(linear_ * local.dpdu),
                    Vec3(linear_ * local.dpdv), reverseOrientation_);
    si->n = si->shading.n = Normal3(n * sign);
    if (!si->wantsNormalDerivatives) return;
    // Of the transformed unit normal: d(N/|N|) = (dN - n (n . dN)) / |N|.
    const auto derivative = [&](glm::dvec3 dn) {
        const glm::dvec3 dN = normalMatrix_ * dn;
        return Vec3((dN - n * glm::dot(n, dN)) * (sign / length));
    };
    si->shading.dndu = derivative(local.dndu);
    si->shading.dndv = derivative(local.dndv);
}

ShapeSample Quadric::SampleAt(glm::dvec3 p, bool wantsUv) const {
    const LocalPoint local = PointAt(p, wantsUv);
    ShapeSample sample;
    sample.p = Point3(ToRender(local.p));
    sample.pError = ErrorBound(sample.p);
    sample.n = Normal3(glm::normalize(normalMatrix_ * local.n) * NormalSign());
    sample.uv = local.uv;
    sample.pdf = float(1 / (ObjectArea() * AreaScale(local.n)));
    return sample;
}

std::optional<ShapeSample> Quadric::SampleArea(int /*primitive*/, Point2 u) const {
    const ShapeSample sample = SampleAt(SamplePoint(u), true);
    if (!(sample.pdf > 0) || !std::isfinite(sample.pdf)) return std::nullopt;
    return sample;
}

std::optional<ShapeSample> Quadric::SampleSolidAngle(int /*primitive*/, const LightReference& ref, Point2 u,
                                                     bool wantsUv) const {
    ShapeSample sample = SampleAt(SamplePoint(u), wantsUv);
    sample.pdf = AreaToSolidAngle(sample.pdf, ref.p, sample.p, sample.n);
    if (!(sample.pdf > 0)) return std::nullopt;
    return sample;
}

float Quadric::PdfSolidAngle(int /*primitive*/, const LightReference& ref, Point3 p, Normal3 n) const {
    // Normals go back to object space by the transpose of the linear part.
    const glm::dvec3 local = glm::normalize(glm::transpose(linear_) * glm::dvec3(n));
    return AreaToSolidAngle(float(1 / (ObjectArea() * AreaScale(local))), ref.p, p, n);
}

std::vector<std::unique_ptr<Shape>> FinishQuadric(const Params& params, std::unique_ptr<Quadric> quadric) {
    const Bounds3 bounds = quadric->Bounds(0);
    if (!IsFinite(bounds.min) || !IsFinite(bounds.max))
        throw SceneError(params.Loc(),
                         fmt::format("{} is too large for floats after the transformation", params.Owner()));
    std::vector<std::unique_ptr<Shape>> shapes;
    shapes.push_back(std::move(quadric));
    return shapes;
}

float GetFiniteFloat(const Params& params, std::string_view name, float fallback) {
    const float value = params.GetFloat(name, fallback);
    if (!std::isfinite(value))
        params.Fail(name, fmt::format("\"{}\" is {}; a finite number is expected", name, value));
    return value;
}

float GetPositiveFloat(const Params& params, std::string_view name, float fallback) {
    const float value = GetFiniteFloat(params, name, fallback);
    if (!(value > 0))
        params.Fail(name, fmt::format("\"{}\" is {}; a number above 0 is expected", name, value));
    return value;
}

double GetPhiMax(const Params& params) {
    const float degrees = GetFiniteFloat(params, "phimax", 360);
    if (!(degrees > 0))
        params.Fail("phimax", fmt::format("\"phimax\" is {}; an angle in (0, 360] is expected", degrees));
    return std::min(double(degrees), 360.) * (kPi / 180);
}

}  // namespace lacquer
