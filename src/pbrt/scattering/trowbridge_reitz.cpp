#include "pbrt/scattering/trowbridge_reitz.h"

namespace lacquer {

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
