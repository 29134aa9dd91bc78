#include "pbrt/shapes/bilinear_mesh.h"

#include <glm/mat2x2.hpp>

#include "pbrt/core/sampling.h"
#include "pbrt/shapes/bilinear_intersect.h"
#include "pbrt/shapes/spherical_sampling.h"

namespace lacquer {

namespace {

// Below, sampling by area is as good; above, the sphere's geometry is too close to degenerate [sr].
constexpr double kMinPatchAngle = 1e-4, kMaxPatchAngle = 6.22;

// v turned by the smallest rotation that takes the unit vector `from` to `to`, which are in one hemisphere.
Vec3 RotateBetween(Vec3 v, Vec3 from, Vec3 to) {
    const Vec3 axis = Cross(from, to);
    const Vec3 turned = Cross(axis, v);
    return v + turned + Cross(axis, turned) / (1 + Dot(from, to));
}

// Inverse of the uv mapping's Jacobian: columns d(u,v)/ds and d(u,v)/dt. Empty where the mapping is singular.
std::optional<glm::mat2> InverseJacobian(Vec2 dstdu, Vec2 dstdv) {
    const float determinant = DifferenceOfProducts(dstdu.x, dstdv.y, dstdu.y, dstdv.x);
    const float size = std::abs(dstdu.x * dstdv.y) + std::abs(dstdu.y * dstdv.x);
    if (!(std::abs(determinant) > 1e-6f * size)) return std::nullopt;
    return glm::mat2(dstdv.y, -dstdu.y, -dstdv.x, dstdu.x) / determinant;
}

}  // namespace

bool BilinearMesh::Patch::IsParallelogram() const {
    const Vec3 twist = (p11 - p01) - (p10 - p00);
    return LengthSquared(twist) <= 1e-10f * std::max(LengthSquared(p10 - p00), LengthSquared(p01 - p00));
}

bool BilinearMesh::Patch::IsRectangle() const {
    const Vec3 x = p10 - p00, y = p01 - p00;
    const float xx = LengthSquared(x), yy = LengthSquared(y), xy = Dot(x, y);
    return xx > 0 && yy > 0 && xy * xy <= 1e-10f * xx * yy && IsParallelogram();
}

BilinearMesh::Patch BilinearMesh::Corners(int primitive) const {
    const glm::uvec4 v = arrays_.patches[size_t(primitive)];
    const std::vector<Point3>& p = arrays_.vertices.p;
    return {p[v.x], p[v.y], p[v.z], p[v.w]};
}

Bounds3 BilinearMesh::Bounds(int primitive) const {
    const Patch patch = Corners(primitive);
    return Bounds3(patch.p00, patch.p10).Union(Bounds3(patch.p01, patch.p11));
}

std::optional<ShapeHit> BilinearMesh::Intersect(const Ray& ray, float tMin, float tMax, int primitive) const {
    const Patch q = Corners(primitive);
    const auto hit = IntersectBilinear(ray, double(tMin), double(tMax), q.p00, q.p10, q.p01, q.p11);
    if (!hit) return std::nullopt;
    const float t = float(hit->t);
    if (!(t > tMin && t < tMax)) return std::nullopt;
    return ShapeHit{t, Vec2(hit->u, hit->v)};
}

Normal3 BilinearMesh::OrientedNormal(int primitive, const Patch& patch, Point2 uv) const {
    const Vec3 cross = patch.Cross(uv.x, uv.y);
    const float length = Length(cross);
    if (!(length > 0)) return Normal3(0);
    const Normal3 n = (flip_ ? -cross : cross) / length;
    if (arrays_.vertices.n.empty()) return n;
    const Normal3 ns = Interpolate(arrays_.vertices.n, primitive, uv);
    return LengthSquared(ns) > 0 ? FaceForward(n, ns) : n;
}

namespace {

// Two products and three sums of float corners, doubled; the intersection itself is in double.
template <class Patch>
Point3 PatchPoint(const Patch& q, Point2 uv, float* error) {
    const float w00 = (1 - uv.x) * (1 - uv.y), w10 = uv.x * (1 - uv.y), w01 = (1 - uv.x) * uv.y,
                w11 = uv.x * uv.y;
    const Vec3 sum = Abs(w00 * q.p00) + Abs(w10 * q.p10) + Abs(w01 * q.p01) + Abs(w11 * q.p11);
    const Vec3 reach = glm::max(Abs(q.p11 - q.p00), Abs(q.p01 - q.p10));
    *error = 12 * MachineEpsilon * MaxComponent(sum) + 2 * MachineEpsilon * MaxComponent(reach);
    return w00 * q.p00 + w10 * q.p10 + w01 * q.p01 + w11 * q.p11;
}

}  // namespace

void BilinearMesh::Interaction(const Ray& ray, const ShapeHit& hit, int primitive,
                               SurfaceInteraction* si) const {
    const Patch patch = Corners(primitive);
    const Point2 uv = hit.coordinates;
    Vec3 dpdu = patch.DpDu(uv.y), dpdv = patch.DpDv(uv.x);

    // The cross product N of the tangents is linear in u and v; so are the derivatives of its direction:
    // dn = (dN - n (n . dN)) / |N|.
    const Vec3 cross = Cross(dpdu, dpdv), twist = (patch.p11 - patch.p01) - (patch.p10 - patch.p00);
    const float length = Length(cross);
    const Normal3 n0 = cross / length;
    si->n = OrientedNormal(primitive, patch, uv);
    Vec3 dndu(0), dndv(0);
    if (si->wantsNormalDerivatives && length > 0) {
        const float scale = (Dot(si->n, n0) < 0 ? -1 : 1) / length;
        const auto derivative = [&](Vec3 dN) { return (dN - n0 * Dot(n0, dN)) * scale; };
        dndu = derivative(Cross(dpdu, twist));
        dndv = derivative(Cross(twist, dpdv));
    }

    // With uv at the corners, all derivatives change to them.
    si->uv = uv;
    glm::mat2 dUvDst(1.f);
    if (!arrays_.vertices.uv.empty()) {
        si->uv = Interpolate(arrays_.vertices.uv, primitive, uv);
        const auto [dstdu, dstdv] = Derivatives(arrays_.vertices.uv, primitive, uv);
        dUvDst = InverseJacobian(dstdu, dstdv).value_or(glm::mat2(1.f));
    }
    const auto change = [&dUvDst](Vec3* du, Vec3* dv) {
        const Vec3 ds = *du * dUvDst[0].x + *dv * dUvDst[0].y, dt = *du * dUvDst[1].x + *dv * dUvDst[1].y;
        *du = ds;
        *dv = dt;
    };
    change(&dpdu, &dpdv);
    change(&dndu, &dndv);
    if (si->n == Normal3(0)) si->n = Normal3(0, 0, 1);
    if (!(LengthSquared(Cross(dpdu, dpdv)) > 0)) CoordinateSystem(si->n, &dpdu, &dpdv);

    si->p = PatchPoint(patch, uv, &si->pError);
    si->dpdu = dpdu;
    si->dpdv = dpdv;
    si->time = ray.time;
    si->faceIndex = arrays_.faceIndices.empty() ? 0 : arrays_.faceIndices[size_t(primitive)];
    si->shading = {si->n, dpdu, dpdv, dndu, dndv};
    if (!arrays_.vertices.n.empty()) SetShadingFrame(primitive, uv, dUvDst, si);
}

void BilinearMesh::SetShadingFrame(int primitive, Point2 uv, const glm::mat2& dUvDst,
                                   SurfaceInteraction* si) const {
    const Normal3 interpolated = Interpolate(arrays_.vertices.n, primitive, uv);
    if (!(LengthSquared(interpolated) > 0)) return;
    const Normal3 ns = Normalize(interpolated);
    Vec3 dnds(0), dndt(0);
    if (si->wantsNormalDerivatives) {
        const auto [dndu, dndv] = Derivatives(arrays_.vertices.n, primitive, uv);
        dnds = dndu * dUvDst[0].x + dndv * dUvDst[0].y;
        dndt = dndu * dUvDst[1].x + dndv * dUvDst[1].y;
    }
    const Normal3 n = FaceForward(si->n, ns);
    si->SetShading(ns, RotateBetween(si->dpdu, n, ns), RotateBetween(si->dpdv, n, ns), dnds, dndt, true);
}

float BilinearMesh::Area(int primitive) const {
    const Patch patch = Corners(primitive);
    if (patch.IsParallelogram()) return Length(patch.Cross(0.5f, 0.5f));
    // Gauss-Legendre, five nodes in each direction of each quarter.
    constexpr float kNodes[5] = {-0.9061798459f, -0.5384693101f, 0, 0.5384693101f, 0.9061798459f};
    constexpr float kWeights[5] = {0.2369268851f, 0.4786286705f, 0.5688888889f, 0.4786286705f, 0.2369268851f};
    double sum = 0;
    for (int cell = 0; cell < 4; ++cell)
        for (int i = 0; i < 5; ++i)
            for (int j = 0; j < 5; ++j) {
                const float u = 0.25f * (1 + kNodes[i]) + 0.5f * float(cell & 1);
                const float v = 0.25f * (1 + kNodes[j]) + 0.5f * float(cell >> 1);
                sum += double(kWeights[i] * kWeights[j] * Length(patch.Cross(u, v)));
            }
    return float(sum / 16);
}

float BilinearMesh::PdfArea(const Patch& patch, Point2 uv) {
    const float w[4] = {Length(patch.Cross(0, 0)), Length(patch.Cross(1, 0)), Length(patch.Cross(0, 1)),
                        Length(patch.Cross(1, 1))};
    const float pdf = PdfBilinear(uv, w) / Length(patch.Cross(uv.x, uv.y));
    return std::isfinite(pdf) ? pdf : 0.f;
}

ShapeSample BilinearMesh::SampleAt(int primitive, const Patch& patch, Point2 uv) const {
    ShapeSample sample;
    sample.p = PatchPoint(patch, uv, &sample.pError);
    sample.n = OrientedNormal(primitive, patch, uv);
    sample.uv = arrays_.vertices.uv.empty() ? uv : Interpolate(arrays_.vertices.uv, primitive, uv);
    return sample;
}

std::optional<ShapeSample> BilinearMesh::SampleArea(int primitive, Point2 u) const {
    const Patch patch = Corners(primitive);
    const float w[4] = {Length(patch.Cross(0, 0)), Length(patch.Cross(1, 0)), Length(patch.Cross(0, 1)),
                        Length(patch.Cross(1, 1))};
    if (!(w[0] + w[1] + w[2] + w[3] > 0)) return std::nullopt;
    const Point2 uv = SampleBilinear(u, w);
    ShapeSample sample = SampleAt(primitive, patch, uv);
    sample.pdf = PdfArea(patch, uv);
    if (!(sample.pdf > 0) || sample.n == Normal3(0)) return std::nullopt;
    return sample;
}

std::optional<ShapeSample> BilinearMesh::SampleSolidAngle(int primitive, const LightReference& ref, Point2 u,
                                                          bool wantsUv) const {
    const Patch patch = Corners(primitive);
    if (!patch.IsRectangle()) return Shape::SampleSolidAngle(primitive, ref, u, wantsUv);
    const SphericalRectangle rectangle(ref.p, patch.p00, patch.p10 - patch.p00, patch.p01 - patch.p00);
    const double solidAngle = rectangle.SolidAngle();
    if (!(solidAngle > kMinPatchAngle && solidAngle < kMaxPatchAngle))
        return Shape::SampleSolidAngle(primitive, ref, u, wantsUv);
    ShapeSample sample = SampleAt(primitive, patch, rectangle.Sample(u));
    sample.pdf = float(1 / solidAngle);
    return sample;
}

float BilinearMesh::PdfSolidAngle(int primitive, const LightReference& ref, Point3 p, Normal3 n) const {
    const Patch q = Corners(primitive);
    if (q.IsRectangle()) {
        const double solidAngle = SphericalRectangle(ref.p, q.p00, q.p10 - q.p00, q.p01 - q.p00).SolidAngle();
        if (solidAngle > kMinPatchAngle && solidAngle < kMaxPatchAngle) return float(1 / solidAngle);
    }
    if (q.IsParallelogram()) return AreaToSolidAngle(1 / Length(q.Cross(0.5f, 0.5f)), ref.p, p, n);
    // The density depends on (u, v): found along the normal, where p is the nearest point of the patch.
    const float reach = 1e-2f * Length(Bounds(primitive).Diagonal());
    const Ray ray{p - reach * n, n};
    std::optional<BilinearHit> hit, next;
    double from = 0;
    while ((next = IntersectBilinear(ray, from, 2 * double(reach), q.p00, q.p10, q.p01, q.p11))) {
        if (!hit || std::abs(next->t - double(reach)) < std::abs(hit->t - double(reach))) hit = next;
        from = next->t;
    }
    return hit ? AreaToSolidAngle(PdfArea(q, Point2(hit->u, hit->v)), ref.p, p, n) : 0.f;
}

std::pair<Vec3, float> BilinearMesh::NormalCone(int primitive) const {
    // Every normal is a positive combination of those at the corners.
    const Patch patch = Corners(primitive);
    Vec3 normals[4], sum(0);
    for (int i = 0; i < 4; ++i) {
        normals[i] = OrientedNormal(primitive, patch, Point2(i & 1, i >> 1));
        sum += normals[i];
    }
    if (!(LengthSquared(sum) > 0)) return Shape::NormalCone(primitive);
    const Vec3 axis = Normalize(sum);
    float cosine = 1;
    for (const Vec3& n : normals)
        if (n != Vec3(0)) cosine = std::min(cosine, Dot(axis, n));
    if (cosine <= 0) return Shape::NormalCone(primitive);
    return {axis, cosine};
}

size_t BilinearMesh::MemoryBytes() const {
    return sizeof(*this) + arrays_.vertices.MemoryBytes() + arrays_.patches.capacity() * sizeof(glm::uvec4) +
           arrays_.faceIndices.capacity() * sizeof(int);
}

}  // namespace lacquer
