// How flakes lie in the plane of texture coordinates.
#pragma once

#include "pbrt/base/texture.h"
#include "pbrt/bxdfs/flakes.h"

namespace lacquer {

/// Round flakes of one size, in the plane of (scale.x u, scale.y v).
struct FlakeLayout {
    uint64_t seed = 0;
    float density = 1;  ///< flakes in a unit of the plane
    float radius = 0.5f;
    Vec2 scale{1};

    float AreaOfFlake() const { return Pi * Sqr(radius); }
    /// The expected share of the plane under flakes, which overlap by chance.
    float Coverage() const;
    /// Tiles of the field of flakes in a unit of the plane.
    double TilesPerUnit() const;
    /// The flakes that touch the footprint of a point: an ellipse in the middle of it, at most four times as
    /// long as wide.
    /// @param mostFlakes  of a footprint that is expected to have more, a part with so many is taken: samples
    ///                    of a pixel lie all over it, and parts are as good on average
    FlakesInWindow WindowAt(const TextureContext& context, float mostFlakes) const;
};

}  // namespace lacquer
