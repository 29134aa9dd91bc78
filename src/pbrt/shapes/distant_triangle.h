// Triangles that look small from a point: points are drawn by the light that a diffuse surface there gets
// from them.
#pragma once

#include <array>
#include <optional>

#include "pbrt/base/interaction.h"

namespace lacquer {

/// A triangle that is about as far away as it is large, or farther. Points are drawn about by cos(theta) over
/// solid angle, without a sine or an arcus: uniformly in the flat triangle between three points on the lines
/// to the corners, which are the nearer the larger their cosines.
class DistantTriangle {
  public:
    /// Empty for triangles that are nearer.
    static std::optional<DistantTriangle> From(const LightReference& ref,
                                               const std::array<Point3, 3>& corners);

    struct Drawn {
        Vec3 b;         ///< barycentric coordinates
        float density;  ///< over area, times the area
    };
    Drawn Sample(Point2 u) const;
    /// Density of Sample at the point of these barycentric coordinates.
    float Density(Vec3 b) const;

  private:
    explicit DistantTriangle(Vec3 weights) : weights_(weights) {}

    Vec3 weights_;  ///< inverse distances of the flat triangle's corners, up to a common factor
};

}  // namespace lacquer
