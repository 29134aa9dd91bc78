#include "pbrt/accel/accelerator.h"
#include "pbrt/core/rng.h"

namespace lacquer {

bool PassesAlpha(const FloatTexture& alpha, const Shape& shape, const Ray& ray, const ShapeHit& hit, int primitive) {
    float a;
    if (const std::optional<float> constant = alpha.Constant()) {
        a = *constant;
    } else {
        SurfaceInteraction si;
        shape.Interaction(ray, hit, primitive, &si);
        a = alpha.Evaluate(TextureContext(si));
    }
    if (a >= 1) return false;
    if (!(a > 0)) return true;
    // The primitive is hashed as well: several surfaces along one ray must decide independently.
    return UnitFloat(Hash(Hash(ray.o, ray.d), primitive, hit.coordinates.x, hit.coordinates.y)) >= a;
}

}  // namespace lacquer
