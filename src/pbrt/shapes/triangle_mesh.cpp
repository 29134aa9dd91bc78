#include "pbrt/shapes/triangle_mesh.h"

#include "pbrt/core/sampling.h"
#include "pbrt/shapes/distant_triangle.h"
#include "pbrt/shapes/spherical_sampling.h"

namespace lacquer {

namespace {

// Of triangles that are not distant. Below, they are seen edge-on, where sampling by area is as good; above,
// the sphere's geometry is too close to degenerate.
bool IsUniformBySolidAngle(float solidAngle) {
    constexpr float kMin = 3e-4f, kMax = 6.22f;  // [sr]
    return solidAngle >= kMin && solidAngle <= kMax;
}

// The sides that meet in the last corner.
struct Sides {
    explicit Sides(const std::array<Point3, 3>& p) : p02(p[0] - p[2]), p12(p[1] - p[2]) {}

    Vec3 p02, p12;
};

// Bound on the error of any b0 p0 + b1 p1 + b2 p2 of the triangle and of a single-precision test of a ray
// that starts there: each rounds in proportion to the coordinates summed, and the test also to the distance
// of the corners. One bound for all points is up to twice that of a point.
float ErrorBound(const std::array<Point3, 3>& p, const Sides& sides) {
    const Vec3 sum = glm::max(glm::max(Abs(p[0]), Abs(p[1])), Abs(p[2]));
    const Vec3 reach = glm::max(glm::max(Abs(sides.p02), Abs(sides.p12)), Abs(sides.p02 - sides.p12));
    return 8 * MachineEpsilon * (MaxComponent(sum) + MaxComponent(reach));
}

// Where u and v do not span the triangle, their derivatives mean nothing: (du, dv) pairs with a determinant
// that is all rounding.
struct UvDifferences {
    explicit UvDifferences(const std::array<Point2, 3>& uv) : d02(uv[0] - uv[2]), d12(uv[1] - uv[2]) {
        const float determinant = DifferenceOfProducts(d02.x, d12.y, d02.y, d12.x);
        const float size = std::abs(d02.x * d12.y) + std::abs(d02.y * d12.x);
        inverse = 1 / determinant;
        degenerate = !(std::abs(determinant) > 1e-6f * size) || !std::isfinite(inverse);
    }
    // Derivatives over u and v of what changes by x02 and x12 along the two sides.
    Vec3 DerivativeU(Vec3 x02, Vec3 x12) const { return (d12.y * x02 - d02.y * x12) * inverse; }
    Vec3 DerivativeV(Vec3 x02, Vec3 x12) const { return (d02.x * x12 - d12.x * x02) * inverse; }

    Vec2 d02, d12;
    float inverse;  // of the determinant
    bool degenerate;
};

// Weights of the corners for a point of the triangle, which rounding may have put next to it. In doubles:
// squares of areas are out of a float's range for sides of less than a nanometre.
Vec3 BarycentricOf(Point3 point, const std::array<Point3, 3>& p) {
    using glm::dvec3;
    const dvec3 side0 = dvec3(p[0]) - dvec3(p[2]), side1 = dvec3(p[1]) - dvec3(p[2]),
                from2 = dvec3(point) - dvec3(p[2]);
    const dvec3 cross = glm::cross(side0, side1);
    const double scale = 1 / glm::dot(cross, cross);
    const double b0 = std::clamp(glm::dot(glm::cross(from2, side1), cross) * scale, 0., 1.);
    const double b1 = std::clamp(glm::dot(glm::cross(side0, from2), cross) * scale, 0., 1 - b0);
    return {b0, b1, 1 - b0 - b1};
}

// Density over solid angle at `from` [1/sr] of a point of a triangle; `density` is that over its area, times
// the area. 0 where there is none.
float DensityToSolidAngle(float density, Point3 from, Point3 point, const std::array<Point3, 3>& p) {
    // The cross product of two sides is a normal that is as long as twice the area, whose square might
    // underflow.
    const Sides sides(p);
    return AreaToSolidAngle(2 * density, from, point, Cross(sides.p02, sides.p12));
}

}  // namespace

TriangleMesh::TriangleMesh(Arrays arrays, bool flip) : arrays_(std::move(arrays)), flip_(flip) {
    PadForEmbree(&arrays_.vertices.p);
    PadForEmbree(&arrays_.triangles);
}

std::array<Point3, 3> TriangleMesh::Corners(int primitive) const {
    const glm::uvec3 v = arrays_.triangles[size_t(primitive)];
    const std::vector<Point3>& p = arrays_.vertices.p;
    return {p[v.x], p[v.y], p[v.z]};
}

std::array<Point2, 3> TriangleMesh::Uvs(int primitive) const {
    const std::vector<Point2>& uv = arrays_.vertices.uv;
    if (uv.empty()) return {Point2(0, 0), Point2(1, 0), Point2(1, 1)};
    const glm::uvec3 v = arrays_.triangles[size_t(primitive)];
    return {uv[v.x], uv[v.y], uv[v.z]};
}

Bounds3 TriangleMesh::Bounds(int primitive) const {
    const std::array<Point3, 3> p = Corners(primitive);
    return Bounds3(p[0], p[1]).Union(p[2]);
}

std::optional<ShapeHit> TriangleMesh::Intersect(const Ray& ray, float tMin, float tMax, int primitive) const {
    using glm::dvec3;
    const std::array<Point3, 3> p = Corners(primitive);
    const dvec3 o(ray.o), d(ray.d), a = dvec3(p[0]) - o, b = dvec3(p[1]) - o, c = dvec3(p[2]) - o;

    // Signed volumes of the ray with each edge: the barycentric coordinates up to a common factor.
    const double wa = glm::dot(d, glm::cross(b, c)), wb = glm::dot(d, glm::cross(c, a)),
                 wc = glm::dot(d, glm::cross(a, b));
    if ((wa < 0 || wb < 0 || wc < 0) && (wa > 0 || wb > 0 || wc > 0)) return std::nullopt;
    const double sum = wa + wb + wc;
    const dvec3 n = glm::cross(b - a, c - a);
    if (sum == 0 || glm::dot(n, n) == 0) return std::nullopt;
    const float t = float(glm::dot(n, a) / glm::dot(n, d));
    if (!(t > tMin && t < tMax)) return std::nullopt;
    return ShapeHit{t, Vec2(wb / sum, wc / sum)};
}

Normal3 TriangleMesh::VertexNormal(int primitive, Vec3 b) const {
    return arrays_.vertices.n.empty() ? Normal3(0) : Interpolate(arrays_.vertices.n, primitive, b);
}

Normal3 TriangleMesh::OrientedNormal(Vec3 cross, Normal3 vertexNormal) const {
    const float length = Length(cross);
    if (!(length > 0)) return Normal3(0);
    const Normal3 n = cross * ((flip_ ? -1.f : 1.f) / length);
    return LengthSquared(vertexNormal) > 0 ? FaceForward(n, vertexNormal) : n;
}

void TriangleMesh::Interaction(const Ray& ray, const ShapeHit& hit, int primitive,
                               SurfaceInteraction* si) const {
    const VertexArrays& vertices = arrays_.vertices;
    const std::array<Point3, 3> p = Corners(primitive);
    const std::array<Point2, 3> uv = Uvs(primitive);
    const Vec3 b(1 - hit.coordinates.x - hit.coordinates.y, hit.coordinates.x, hit.coordinates.y);

    // Tangents along u and v; any frame in the plane where uv gives none.
    const Sides sides(p);
    const UvDifferences duv(uv);
    const Normal3 vertexNormal = VertexNormal(primitive, b);
    const Normal3 n = OrientedNormal(Cross(sides.p02, sides.p12), vertexNormal);
    si->dpdu = si->dpdv = Vec3(0);
    if (!duv.degenerate) {
        si->dpdu = duv.DerivativeU(sides.p02, sides.p12);
        si->dpdv = duv.DerivativeV(sides.p02, sides.p12);
    }
    const float spanned = LengthSquared(Cross(si->dpdu, si->dpdv));
    if (!(spanned > 0) || !std::isfinite(spanned)) CoordinateSystem(n, &si->dpdu, &si->dpdv);

    si->p = b.x * p[0] + b.y * p[1] + b.z * p[2];
    si->pError = ErrorBound(p, sides);
    si->n = n;
    si->uv = b.x * uv[0] + b.y * uv[1] + b.z * uv[2];
    si->time = ray.time;
    si->faceIndex = arrays_.faceIndices.empty() ? 0 : arrays_.faceIndices[size_t(primitive)];
    si->shading = {n, si->dpdu, si->dpdv, Vec3(0), Vec3(0)};
    if (vertices.n.empty() && vertices.s.empty()) return;

    Vec3 dndu(0), dndv(0);
    if (si->wantsNormalDerivatives && !vertices.n.empty() && !duv.degenerate) {
        const glm::uvec3 v = arrays_.triangles[size_t(primitive)];
        const Vec3 dn02 = vertices.n[v.x] - vertices.n[v.z], dn12 = vertices.n[v.y] - vertices.n[v.z];
        dndu = duv.DerivativeU(dn02, dn12);
        dndv = duv.DerivativeV(dn02, dn12);
    }
    const Normal3 ns = LengthSquared(vertexNormal) > 0 ? Normalize(vertexNormal) : n;
    // The tangent, from S or along u, made orthogonal to the shading normal.
    Vec3 tangent = ShadingTangent(primitive, b, si->dpdu), bitangent = Cross(ns, tangent);
    if (LengthSquared(bitangent) > 0)
        tangent = Cross(bitangent, ns);
    else
        CoordinateSystem(ns, &tangent, &bitangent);
    si->SetShading(ns, tangent, bitangent, dndu, dndv, true);
}

Vec3 TriangleMesh::ShadingTangent(int primitive, Vec3 b, Vec3 dpdu) const {
    if (arrays_.vertices.s.empty()) return dpdu;
    const Vec3 interpolated = Interpolate(arrays_.vertices.s, primitive, b);
    return LengthSquared(interpolated) > 0 ? interpolated : dpdu;
}

float TriangleMesh::Area(int primitive) const {
    const std::array<Point3, 3> p = Corners(primitive);
    return 0.5f * Length(Cross(p[1] - p[0], p[2] - p[0]));
}

ShapeSample TriangleMesh::SampleAt(int primitive, const std::array<Point3, 3>& p, Vec3 b,
                                   bool wantsUv) const {
    const Sides sides(p);
    ShapeSample sample;
    sample.p = b.x * p[0] + b.y * p[1] + b.z * p[2];
    sample.pError = ErrorBound(p, sides);
    sample.n = OrientedNormal(Cross(sides.p02, sides.p12), VertexNormal(primitive, b));
    if (wantsUv) {
        const std::array<Point2, 3> uv = Uvs(primitive);
        sample.uv = b.x * uv[0] + b.y * uv[1] + b.z * uv[2];
    }
    return sample;
}

std::optional<ShapeSample> TriangleMesh::SampleArea(int primitive, Point2 u) const {
    const float pdf = 1 / Area(primitive);
    if (!(pdf > 0) || !std::isfinite(pdf)) return std::nullopt;
    ShapeSample sample = SampleAt(primitive, Corners(primitive), SampleUniformTriangle(u), true);
    sample.pdf = pdf;
    return sample;
}

std::optional<ShapeSample> TriangleMesh::SampleSolidAngle(int primitive, const LightReference& ref, Point2 u,
                                                          bool wantsUv) const {
    const std::array<Point3, 3> p = Corners(primitive);
    if (const std::optional<DistantTriangle> distant = DistantTriangle::From(ref, p)) {
        const DistantTriangle::Drawn drawn = distant->Sample(u);
        ShapeSample sample = SampleAt(primitive, p, drawn.b, wantsUv);
        sample.pdf = DensityToSolidAngle(drawn.density, ref.p, sample.p, p);
        if (!(sample.pdf > 0)) return std::nullopt;
        return sample;
    }
    const SphericalTriangle seen(ref.p, p[0], p[1], p[2]);
    const float solidAngle = seen.SolidAngle();
    if (!IsUniformBySolidAngle(solidAngle)) return Shape::SampleSolidAngle(primitive, ref, u, wantsUv);
    const std::optional<Vec2> b = seen.Sample(u);
    if (!b) return std::nullopt;
    ShapeSample sample = SampleAt(primitive, p, Vec3(1 - b->x - b->y, b->x, b->y), wantsUv);
    sample.pdf = 1 / solidAngle;
    return sample;
}

float TriangleMesh::PdfSolidAngle(int primitive, const LightReference& ref, Point3 p, Normal3 n) const {
    const std::array<Point3, 3> corners = Corners(primitive);
    if (const std::optional<DistantTriangle> distant = DistantTriangle::From(ref, corners))
        return DensityToSolidAngle(distant->Density(BarycentricOf(p, corners)), ref.p, p, corners);
    const float solidAngle = SphericalTriangle(ref.p, corners[0], corners[1], corners[2]).SolidAngle();
    if (!IsUniformBySolidAngle(solidAngle)) return Shape::PdfSolidAngle(primitive, ref, p, n);
    return 1 / solidAngle;
}

std::pair<Vec3, float> TriangleMesh::NormalCone(int primitive) const {
    const Sides sides(Corners(primitive));
    const Normal3 n = OrientedNormal(Cross(sides.p02, sides.p12), VertexNormal(primitive, Vec3(1.f / 3)));
    if (n == Normal3(0)) return Shape::NormalCone(primitive);
    return {n, 1.f};
}

std::optional<TriangleView> TriangleMesh::Triangles() const {
    return TriangleView{arrays_.vertices.p, arrays_.triangles};
}

size_t TriangleMesh::MemoryBytes() const {
    return sizeof(*this) + arrays_.vertices.MemoryBytes() +
           arrays_.triangles.capacity() * sizeof(glm::uvec3) + arrays_.faceIndices.capacity() * sizeof(int);
}

}  // namespace lacquer
