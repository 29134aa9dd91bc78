#include "pbrt/shapes/bilinear_intersect.h"

namespace lacquer {

namespace {

using glm::dvec3;

// Neighbours that share an edge must not leave a gap of rounding errors between them.
constexpr double kEdge = 1e-10;

double Determinant(dvec3 a, dvec3 b, dvec3 c) { return glm::dot(a, glm::cross(b, c)); }

// Roots of a u^2 + b u + c without cancellation; one of them is far outside [0,1] when a is only rounding.
struct Roots {
    int count = 0;
    double u[2];
};
Roots SolveQuadratic(double a, double b, double c) {
    Roots roots;
    const double discriminant = b * b - 4 * a * c;
    if (!(discriminant >= 0)) return roots;
    const double q = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
    if (a != 0) roots.u[roots.count++] = q / a;
    if (q != 0) roots.u[roots.count++] = c / q;
    return roots;
}

}  // namespace

std::optional<BilinearHit> IntersectBilinear(const Ray& ray, double tMin, double tMax, Point3 p00, Point3 p10,
                                             Point3 p01, Point3 p11) {
    // Corners as seen from the ray's origin.
    const dvec3 o(ray.o), d(ray.d), q00 = dvec3(p00) - o, q10 = dvec3(p10) - o, q01 = dvec3(p01) - o,
                                    q11 = dvec3(p11) - o;

    // The line of constant u meets the ray where a u^2 + b u + c = 0: zero volume of its ends and the ray.
    const double c = glm::dot(glm::cross(q00, d), q01 - q00);
    const double a = glm::dot(glm::cross(q10 - q00, q01 - q11), d);
    const double b = glm::dot(glm::cross(q10, d), q11 - q10) - (a + c);
    const Roots roots = SolveQuadratic(a, b, c);

    std::optional<BilinearHit> nearest;
    for (int i = 0; i < roots.count; ++i) {
        if (!(roots.u[i] >= -kEdge && roots.u[i] <= 1 + kEdge)) continue;
        // On that line, the point next to the ray.
        const double u = std::clamp(roots.u[i], 0., 1.);
        const dvec3 start = (1 - u) * q00 + u * q10, along = (1 - u) * (q01 - q00) + u * (q11 - q10);
        const dvec3 normal = glm::cross(d, along);
        const double normal2 = glm::dot(normal, normal);
        if (!(normal2 > 0)) continue;
        const double v = Determinant(start, d, normal) / normal2,
                     t = Determinant(start, along, normal) / normal2;
        if (!(v >= -kEdge && v <= 1 + kEdge && t > tMin && t < tMax)) continue;
        if (!nearest || t < nearest->t) nearest = BilinearHit{t, u, std::clamp(v, 0., 1.)};
    }
    return nearest;
}

}  // namespace lacquer
