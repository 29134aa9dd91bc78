#include "pbrt/core/vec.h"

#include "pbrt/core/math.h"

namespace lacquer {

Vec3 EqualAreaSquareToSphere(Point2 p) {
    const float u = 2 * p.x - 1, v = 2 * p.y - 1;
    const float au = std::abs(u), av = std::abs(v);
    const float d = 1 - (au + av), r = 1 - std::abs(d);
    const float phi = (r == 0 ? 1.f : (av - au) / r + 1) * PiOver4;
    const float z = std::copysign(1 - r * r, d);
    const float scale = r * SafeSqrt(2 - r * r);
    return {std::copysign(std::cos(phi), u) * scale, std::copysign(std::sin(phi), v) * scale, z};
}

Point2 EqualAreaSphereToSquare(Vec3 d) {
    const float x = std::abs(d.x), y = std::abs(d.y), z = std::abs(d.z);
    const float r = SafeSqrt(1 - z);
    const float larger = std::max(x, y), smaller = std::min(x, y);
    float phi = ATan2(smaller, larger) * (2 * InvPi);
    if (x < y) phi = 1 - phi;
    float v = phi * r, u = r - v;
    if (d.z < 0) {
        std::swap(u, v);
        u = 1 - u;
        v = 1 - v;
    }
    return {(std::copysign(u, d.x) + 1) * 0.5f, (std::copysign(v, d.y) + 1) * 0.5f};
}

Point2 WrapEqualAreaSquare(Point2 p) {
    if (p.x < 0 || p.x > 1) p = {p.x < 0 ? -p.x : 2 - p.x, 1 - p.y};
    if (p.y < 0 || p.y > 1) p = {1 - p.x, p.y < 0 ? -p.y : 2 - p.y};
    return p;
}

}  // namespace lacquer
