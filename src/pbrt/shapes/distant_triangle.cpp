#include "pbrt/shapes/distant_triangle.h"

#include <algorithm>
#include <cmath>

#include "pbrt/core/sampling.h"

namespace lacquer {

std::optional<DistantTriangle> DistantTriangle::From(const LightReference& ref,
                                                     const std::array<Point3, 3>& corners) {
    constexpr float kMaxSize = 1.25f;  // longest side over the distance of the nearest corner
    const Vec3 d0 = corners[0] - ref.p, d1 = corners[1] - ref.p, d2 = corners[2] - ref.p;
    const Vec3 squared(LengthSquared(d0), LengthSquared(d1), LengthSquared(d2));
    const float longest = std::max({LengthSquared(d1 - d0), LengthSquared(d2 - d1), LengthSquared(d0 - d2)});
    const float nearest = std::min({squared.x, squared.y, squared.z});
    if (!(longest < kMaxSize * kMaxSize * nearest)) return std::nullopt;

    // The density of what is drawn between these points is as the cube of the weight at each corner, and a
    // straight line close to the cube root of a cosine; what scatters otherwise than by cosines gets some of
    // everything.
    constexpr float kAnyway = 0.4f;
    const Vec3 distances = glm::sqrt(squared), inverse = 1.f / distances;
    const Vec3 cosines = Abs(Vec3(Dot(d0, ref.ns), Dot(d1, ref.ns), Dot(d2, ref.ns))) * inverse;
    return DistantTriangle((kAnyway + (1 - kAnyway) * cosines) * (distances.x * inverse));
}

// With u uniform and w the weights, b_i = u_i w_i / (u . w), whose Jacobian is w_0 w_1 w_2 / (u . w)^3.
DistantTriangle::Drawn DistantTriangle::Sample(Point2 u) const {
    const Vec3 uniform = SampleUniformTriangle(u), weighted = uniform * weights_;
    const float sum = weighted.x + weighted.y + weighted.z;
    return {weighted * (1 / sum), sum * sum * sum / (weights_.x * weights_.y * weights_.z)};
}

float DistantTriangle::Density(Vec3 b) const {
    const Vec3 w = weights_;
    // 1 / (u . w), for the u add up to 1.
    const float inverse = b.x / w.x + b.y / w.y + b.z / w.z;
    return 1 / (inverse * inverse * inverse * (w.x * w.y * w.z));
}

}  // namespace lacquer
