#include "pbrt/base/interaction.h"

namespace lacquer {

namespace {

// Footprints beyond this say no more than "very blurred", and must not overflow in the filters.
constexpr float kMaxFootprint = 1e8f;

float BoundFootprint(float x) {
    return std::isfinite(x) ? std::clamp(x, -kMaxFootprint, kMaxFootprint) : 0.f;
}

}  // namespace

// Normal equations of [dpdu dpdv] (du, dv) = dp, once for each screen axis.
void SurfaceInteraction::ComputeUvFootprint() {
    const float duu = Dot(dpdu, dpdu), duv = Dot(dpdu, dpdv), dvv = Dot(dpdv, dpdv);
    const float determinant = DifferenceOfProducts(duu, dvv, duv, duv);
    const float inverse = determinant != 0 ? 1 / determinant : 0.f;
    const auto solve = [&](Vec3 dp, float* du, float* dv) {
        const float bu = Dot(dpdu, dp), bv = Dot(dpdv, dp);
        *du = BoundFootprint(DifferenceOfProducts(dvv, bu, duv, bv) * inverse);
        *dv = BoundFootprint(DifferenceOfProducts(duu, bv, duv, bu) * inverse);
    };
    solve(dpdx, &dudx, &dvdx);
    solve(dpdy, &dudy, &dvdy);
}

}  // namespace lacquer
