// How far what the camera sees moves on the image while the shutter is open.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "pbrt/film/first_hit.h"
#include "pbrt/scene/scene.h"

namespace lacquer {

/// Displacements from where the image shows a point of a surface when the shutter opens to where it does when
/// the shutter closes, of camera and surface together. Constant after construction.
class ImageMotion {
  public:
    /// @param scene  outlives it; its camera has RasterOf()
    explicit ImageMotion(const Scene& scene);

    /// Right and up [pixels]: of the surface that was hit; or of what lies infinitely far along the ray,
    /// where neither a surface nor a medium ends it. Empty where the image shows it at one of the two times
    /// at most.
    std::optional<Vec2> Of(const FirstHit& hit, const Ray& ray) const;

  private:
    /// When the shutter opens, and when it closes.
    using Pair = std::array<Transform, 2>;
    std::optional<Vec2> Between(const Point3& first, const Point3& last, bool isDirection) const;

    const Scene& scene_;
    Pair renderFromCamera_;
    std::vector<Pair> renderFromObject_;  ///< of instances; in use for those that move
};

}  // namespace lacquer
