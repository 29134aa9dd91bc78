// Shape "curve": thin fibres along Bezier curves and B-splines.
//
//   "point3 P" []                                  required  control points
//   "integer degree"                               3         2 or 3
//   "string basis"                                 bezier    or "bspline"
//   "string type"                                  flat      faces the ray; "cylinder": the normals of one;
//                                                            "ribbon": faces N
//   "float width", "float width0", "float width1"  1         full width: all along, at the start, at the end
//   "normal N" []                                  -         ribbons only: one for each end of a segment
//   "integer splitdepth"                           -         has no effect: curves are split by their shape
#include <fmt/format.h>

#include <glm/matrix.hpp>

#include "pbrt/base/shape.h"
#include "pbrt/core/progress.h"
#include "pbrt/shapes/curve_segment.h"
#include "pbrt/shapes/mesh_arrays.h"

namespace lacquer {

namespace {

enum class CurveType : uint8_t { Flat, Cylinder, Ribbon };

struct CurveWidths {
    float start, end;
};

/// All segments of one directive. A scene may have very many of these with one segment each: objects are
/// small. A primitive is a part of a segment, so that the boxes of long thin curves are tight.
///
/// Under rotations and uniform scaling the curve is kept in rendering space. Under other transforms rays are
/// taken to object space, for there the curve faces them and has its width.
class Curve final : public Shape {
  public:
    Curve(const Transform& renderFromObject, bool reverseOrientation, CurveType type,
          std::vector<Point3> points, std::vector<Normal3> normals, CurveWidths widths);

    int NumPrimitives() const override { return numSegments_ << log2Parts_; }
    Bounds3 Bounds(int primitive) const override;
    std::optional<ShapeHit> Intersect(const Ray& ray, float tMin, float tMax, int primitive) const override;
    void Interaction(const Ray& ray, const ShapeHit& hit, int primitive,
                     SurfaceInteraction* si) const override;
    // A curve emits nothing: WhyNoEmitter() has said so before anybody asks.
    float Area(int) const override { return 0; }
    std::optional<ShapeSample> SampleArea(int, Point2) const override { return std::nullopt; }
    std::string WhyNoEmitter() const override { return "a curve cannot be an area light"; }
    size_t MemoryBytes() const override;

  private:
    BezierPoints Segment(int segment) const {
        const Point3* p = &points_[size_t(3 * segment)];
        return {ControlValues{p[0].x, p[1].x, p[2].x, p[3].x}, ControlValues{p[0].y, p[1].y, p[2].y, p[3].y},
                ControlValues{p[0].z, p[1].z, p[2].z, p[3].z}};
    }
    /// A part, with the widths and normals of its segment.
    CurveStrip Strip(int segment, int log2Parts, int part) const;
    Bounds3 BoundsOfPart(int segment, int log2Parts, int part) const;
    int SegmentOf(int primitive) const { return primitive >> log2Parts_; }
    int PartIndexOf(int primitive) const { return primitive & ((1 << log2Parts_) - 1); }
    void ChooseParts();

    std::unique_ptr<Point3[]> points_;             ///< 3 numSegments + 1
    std::unique_ptr<Normal3[]> normals_;           ///< of ribbons: numSegments + 1
    std::unique_ptr<Transform> renderFromObject_;  ///< null where the points are in rendering space
    int numSegments_;
    CurveWidths widths_;
    /// Bound on the error of a point in units of the width: what the transform makes of (1, 1, 1).
    float errorPerWidth_;
    CurveType type_;
    uint8_t log2Parts_ = 0;
    bool reverseOrientation_;
};

/// The factor of a rotation with uniform scaling; 0 for other matrices, among them those that mirror.
float SimilarityScale(const glm::mat3& m) {
    const float xx = Dot(m[0], m[0]), tolerance = 1e-5f * xx;
    const bool equal =
        std::abs(Dot(m[1], m[1]) - xx) < tolerance && std::abs(Dot(m[2], m[2]) - xx) < tolerance;
    const bool orthogonal = std::abs(Dot(m[0], m[1])) < tolerance && std::abs(Dot(m[0], m[2])) < tolerance &&
                            std::abs(Dot(m[1], m[2])) < tolerance;
    return equal && orthogonal && glm::determinant(m) > 0 ? std::sqrt(xx) : 0.f;
}

template <class T>
std::unique_ptr<T[]> ArrayOf(const std::vector<T>& values) {
    if (values.empty()) return nullptr;
    auto array = std::make_unique<T[]>(values.size());
    std::copy(values.begin(), values.end(), array.get());
    return array;
}

Curve::Curve(const Transform& renderFromObject, bool reverseOrientation, CurveType type,
             std::vector<Point3> points, std::vector<Normal3> normals, CurveWidths widths)
    : numSegments_(int(points.size() / 3)),
      widths_(widths),
      type_(type),
      reverseOrientation_(reverseOrientation) {
    const glm::mat3 linear(renderFromObject.Matrix());
    const Vec3 reach = Abs(linear[0]) + Abs(linear[1]) + Abs(linear[2]);
    errorPerWidth_ = MaxComponent(reach);
    if (const float scale = SimilarityScale(linear); scale > 0) {
        for (Point3& p : points) p = renderFromObject.Point(p);
        for (Normal3& n : normals) n = Normalize(WithModerateLength(renderFromObject.Normal(n)));
        widths_ = {widths.start * scale, widths.end * scale};
        errorPerWidth_ /= scale;
    } else {
        renderFromObject_ = std::make_unique<Transform>(renderFromObject);
    }
    points_ = ArrayOf(points);
    normals_ = ArrayOf(normals);
    ChooseParts();
}

/// Halving a slanted fibre halves the surface of its boxes, and with it the rays that try the fibre for
/// nothing; a straight one along an axis gains nothing. A sample of the segments decides for all.
void Curve::ChooseParts() {
    const auto surface = [&](int log2Parts) {
        double sum = 0;
        const int step = std::max(1, numSegments_ / 32);
        for (int segment = 0; segment < numSegments_; segment += step)
            for (int part = 0; part < 1 << log2Parts; ++part)
                sum += double(BoundsOfPart(segment, log2Parts, part).SurfaceArea());
        return sum;
    };
    // Primitives are counted in an int.
    double current = surface(0);
    while (log2Parts_ < kMaxLog2CurveParts && numSegments_ < 1 << (30 - kMaxLog2CurveParts)) {
        const double halved = surface(log2Parts_ + 1);
        if (!(halved < 0.7 * current)) break;
        current = halved;
        ++log2Parts_;
    }
}

CurveStrip Curve::Strip(int segment, int log2Parts, int part) const {
    const float numSegments = float(numSegments_), partLength = 1 / float(1 << log2Parts);
    CurveStrip strip;
    strip.p = PartOf(Segment(segment), log2Parts, part);
    strip.u0 = float(part) * partLength;
    strip.u1 = float(part + 1) * partLength;
    strip.width0 = Lerp(float(segment) / numSegments, widths_.start, widths_.end);
    strip.width1 = Lerp(float(segment + 1) / numSegments, widths_.start, widths_.end);
    if (normals_) strip.normals = &normals_[size_t(segment)];
    return strip;
}

Bounds3 Curve::BoundsOfPart(int segment, int log2Parts, int part) const {
    const CurveStrip strip = Strip(segment, log2Parts, part);
    Bounds3 bounds;
    for (int i = 0; i < 4; ++i) bounds = bounds.Union(strip.p[i]);
    // Room for the strip, and for the rounding of rays and parts.
    const float radius = 0.5f * std::max(strip.WidthAt(strip.u0), strip.WidthAt(strip.u1));
    const float reach = MaxComponent(glm::max(Abs(bounds.min), Abs(bounds.max)));
    const Vec3 pad(radius * (1 + 1e-4f) + 8 * MachineEpsilon * reach);
    bounds.min -= pad;
    bounds.max += pad;
    return renderFromObject_ ? renderFromObject_->Bounds(bounds) : bounds;
}

Bounds3 Curve::Bounds(int primitive) const {
    return BoundsOfPart(SegmentOf(primitive), log2Parts_, PartIndexOf(primitive));
}

std::optional<ShapeHit> Curve::Intersect(const Ray& ray, float tMin, float tMax, int primitive) const {
    const CurveStrip strip = Strip(SegmentOf(primitive), log2Parts_, PartIndexOf(primitive));
    const std::optional<CurveHit> hit =
        IntersectCurve(renderFromObject_ ? renderFromObject_->InverseRay(ray) : ray, tMin, tMax, strip);
    if (!hit) return std::nullopt;
    return ShapeHit{hit->t, {hit->u, hit->v}};
}

void Curve::Interaction(const Ray& ray, const ShapeHit& hit, int primitive, SurfaceInteraction* si) const {
    const CurveStrip strip = Strip(SegmentOf(primitive), 0, 0);
    const float u = hit.coordinates.x, v = hit.coordinates.y;
    const Vec3 d = renderFromObject_ ? renderFromObject_->InverseVector(ray.d) : ray.d;
    const float width = std::max(strip.WidthSeen(u, Normalize(d)), 1e-30f);

    Vec3 dpdu = strip.p.DerivativeAt(u);
    if (!(LengthSquared(dpdu) > 0)) dpdu = strip.p[3] - strip.p[0];
    Vec3 across = Cross(type_ == CurveType::Ribbon ? strip.NormalAt(u) : d, dpdu);
    if (!(LengthSquared(across) > 0)) {
        // No direction across is better than another one.
        Vec3 other;
        if (!(LengthSquared(dpdu) > 0)) dpdu = Vec3(1, 0, 0);
        CoordinateSystem(Normalize(dpdu), &across, &other);
    }
    Vec3 dpdv = Normalize(across) * width;
    if (type_ == CurveType::Cylinder) {
        // From one edge to the other, the tangent turns from behind the fibre to before it.
        const float theta = PiOver2 * (2 * v - 1);
        dpdv = std::cos(theta) * dpdv - std::sin(theta) * Cross(Normalize(dpdu), dpdv);
    }
    if (renderFromObject_) {
        dpdu = renderFromObject_->Vector(dpdu);
        dpdv = renderFromObject_->Vector(dpdv);
    }
    const Point3 p = ray(hit.t);
    // Rays leave the fibre at a distance of its width, beyond which it cannot shadow itself.
    const float error = errorPerWidth_ * width + 8 * MachineEpsilon * MaxComponent(Abs(p));
    si->time = ray.time;
    si->faceIndex = 0;
    si->SetGeometry(p, error, {u, v}, dpdu, dpdv, reverseOrientation_);
}

size_t Curve::MemoryBytes() const {
    size_t bytes = sizeof(*this) + size_t(3 * numSegments_ + 1) * sizeof(Point3);
    if (normals_) bytes += size_t(numSegments_ + 1) * sizeof(Normal3);
    if (renderFromObject_) bytes += sizeof(Transform);
    return bytes;
}

// --- parameters ---

struct ControlPoints {
    std::vector<Point3> p;
    int degree;
    bool isBSpline;

    size_t NumSegments() const {
        return isBSpline ? p.size() - size_t(degree) : (p.size() - 1) / size_t(degree);
    }
};

ControlPoints GetControlPoints(const Params& params) {
    ControlPoints control;
    control.degree = params.GetIntInRange("degree", 3, 2, 3);
    control.isBSpline = params.GetChoice("basis", "bezier", {"bezier", "bspline"}) == "bspline";
    control.p = params.GetPoint3s("P");
    const size_t count = control.p.size(), degree = size_t(control.degree);
    if (count == 0) params.Fail("P", "a curve needs its control points: \"point3 P\" is expected");
    if (control.isBSpline && count < degree + 1)
        params.Fail("P", fmt::format("\"P\" has {} points; a B-spline of degree {} has at least {}", count,
                                     degree, degree + 1));
    if (!control.isBSpline && (count < degree + 1 || (count - 1) % degree != 0))
        params.Fail("P", fmt::format("\"P\" has {} points; a Bezier curve of degree {} has {}, {}, {}, ...",
                                     count, degree, degree + 1, 2 * degree + 1, 3 * degree + 1));
    return control;
}

CurveType GetType(const Params& params) {
    const std::string type = params.GetChoice("type", "flat", {"flat", "cylinder", "ribbon"});
    return type == "flat" ? CurveType::Flat : type == "cylinder" ? CurveType::Cylinder : CurveType::Ribbon;
}

float GetWidth(const Params& params, std::string_view name, float fallback) {
    const float width = params.GetFloat(name, fallback);
    if (width < 0)
        params.Fail(name, fmt::format("\"{}\" is {}; a width of at least 0 is expected", name, width));
    return width;
}

CurveWidths GetWidths(const Params& params) {
    const float width = GetWidth(params, "width", 1);
    return {GetWidth(params, "width0", width), GetWidth(params, "width1", width)};
}

std::vector<Normal3> GetRibbonNormals(const ShapeArgs& args, CurveType type, size_t numSegments) {
    const Params& params = args.params;
    std::vector<Normal3> normals = params.GetNormals("N");
    if (type != CurveType::Ribbon) {
        if (!normals.empty() && args.observer)
            args.observer->Warn(
                fmt::format("{}: warning: \"N\" has no effect: only curves of the type "
                            "\"ribbon\" have normals of their own",
                            params.LocOf("N").ToString()));
        return {};
    }
    if (normals.size() != numSegments + 1)
        params.Fail("N", fmt::format("\"N\" has {} normals; a ribbon of {} segments has {}, one for each end",
                                     normals.size(), numSegments, numSegments + 1));
    for (size_t i = 0; i < normals.size(); ++i) {
        const Normal3 unit = Normalize(WithModerateLength(normals[i]));
        if (!IsFinite(unit) || unit == Normal3(0))
            params.Fail("N", fmt::format("element {} of \"N\" has no direction; a normal is expected", i));
        normals[i] = unit;
    }
    return normals;
}

std::vector<std::unique_ptr<Shape>> CreateCurve(const ShapeArgs& args) {
    const Params& params = args.params;
    const ControlPoints control = GetControlPoints(params);
    const CurveType type = GetType(params);
    const CurveWidths widths = GetWidths(params);
    std::vector<Normal3> normals = GetRibbonNormals(args, type, control.NumSegments());
    params.Ignore("integer", "splitdepth");
    params.Ignore("float", "splitdepth");

    auto curve = std::make_unique<Curve>(args.renderFromObject, args.reverseOrientation, type,
                                         ToCubicBezier(control.p, control.degree, control.isBSpline),
                                         std::move(normals), widths);
    for (int i = 0; i < curve->NumPrimitives(); ++i) {
        // Beyond this, squares of lengths overflow.
        constexpr float kLargest = 1e18f;
        const Bounds3 bounds = curve->Bounds(i);
        if (!(MaxComponent(glm::max(Abs(bounds.min), Abs(bounds.max))) < kLargest) || !IsFinite(bounds.min) ||
            !IsFinite(bounds.max))
            throw SceneError(params.Loc(), fmt::format("{} is too large for floats after the transformation",
                                                       params.Owner()));
    }
    std::vector<std::unique_ptr<Shape>> shapes;
    shapes.push_back(std::move(curve));
    return shapes;
}

}  // namespace

LACQUER_REGISTER(ShapeKind, "curve", CreateCurve);

}  // namespace lacquer
