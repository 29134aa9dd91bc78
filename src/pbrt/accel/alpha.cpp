#include "pbrt/accel/accelerator.h"
#include "pbrt/core/rng.h"

namespace lacquer {

bool PassesAlpha(const FloatTexture& alpha, const Shape& shape, const Ray& ray, const ShapeHit& hit,
                 int primitive) {
    float a;
    if (const std::optional<float> constant = alpha.Constant()) {
        a = *constant;
    } else {
        SurfaceInteraction si;
        si.wantsNormalDerivatives = false;
        shape.Interaction(ray, hit, primitive, &si);
        a = alpha.Evaluate(TextureContext(si));
    }
    if (a >= 1) return false;
    if (!(a > 0)) return true;
    // Several surfaces along one ray must decide independently: their distances tell them apart even where
    // they are copies of each other that are met at equal coordinates.
    return UnitFloat(Hash(Hash(ray.o, ray.d), primitive, hit.t, hit.coordinates.x, hit.coordinates.y)) >= a;
}

}  // namespace lacquer
