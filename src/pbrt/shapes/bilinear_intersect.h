// Ray against bilinear patch.
#pragma once

#include <optional>

#include "pbrt/core/vec.h"

namespace lacquer {

struct BilinearHit {
    double t, u, v;
};

/// Nearest meeting of a ray with the patch of corners p00, p10, p01, p11 (u first) with tMin < t < tMax, in
/// double and inclusive of edges. Empty for patches that are a line or a point. [Reshetov 2019]
std::optional<BilinearHit> IntersectBilinear(const Ray& ray, double tMin, double tMax, Point3 p00, Point3 p10,
                                             Point3 p01, Point3 p11);

}  // namespace lacquer
