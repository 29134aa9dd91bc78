#include "pbrt/scattering/trowbridge_reitz.h"

namespace lacquer {

// In the space stretched by 1/alpha the facets form a hemisphere. Mirrored at its visible normals, the view
// direction covers the cap z > -w.z evenly [Dupuy and Benyoub 2023, sec. 3].
Vec3 TrowbridgeReitz::SampleVisible(Vec3 w, Point2 u) const {
    const Vec3 view = Stretch(w);
    // Draw the mirrored direction; 1 - z is known exactly, which keeps the digits of the sine.
    const float oneMinusZ = u.y * (1 + view.z);
    const float sinTheta = SafeSqrt(oneMinusZ * (2 - oneMinusZ));
    const Vec3 mirrored = SphericalDirection(sinTheta, 1 - oneMinusZ, 2 * Pi * u.x);
    // The half vector is the normal; stretch it back.
    const Vec3 h = mirrored + view;
    const Vec3 wm{alphaX_ * h.x, alphaY_ * h.y, std::max(h.z, 0.f)};
    const float length2 = LengthSquared(wm);
    return length2 > 0 ? wm / std::sqrt(length2) : Vec3(0, 0, 1);
}

Point2 TrowbridgeReitz::InvertVisible(Vec3 w, Vec3 wm) const {
    const Vec3 view = Stretch(w);
    const Vec3 n = Normalize({wm.x * invAlphaX_, wm.y * invAlphaY_, wm.z});
    const Vec3 mirrored = 2 * Dot(view, n) * n - view;
    // Near the pole 1 - z is better known from x and y.
    const float sin2 = Sqr(mirrored.x) + Sqr(mirrored.y);
    const float oneMinusZ = mirrored.z > 0 ? sin2 / (1 + mirrored.z) : 1 - mirrored.z;
    return {SphericalPhi(mirrored) * Inv2Pi, oneMinusZ / (1 + view.z)};
}

}  // namespace lacquer
