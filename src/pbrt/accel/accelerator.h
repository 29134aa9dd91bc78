// Finding what a ray hits. Embree stands behind it, and in embree.cpp only.
#pragma once

#include <memory>
#include <vector>

#include "pbrt/base/shape.h"

namespace lacquer {

/// A hit that names its shape by index; Scene turns it into a SurfaceInteraction.
struct Hit {
    float t = 0;
    Vec2 coordinates{0};  ///< see ShapeHit
    int group = 0;        ///< 0 is the world, others are the objects that instances place
    int geometry = 0;     ///< index in its group
    int primitive = 0;    ///< index in its shape
    int instance = -1;    ///< index of the instance, -1 in the world itself
};

/// A shape and the texture that makes holes in it (null: none).
struct AccelGeometry {
    const Shape* shape = nullptr;
    const FloatTexture* alpha = nullptr;
};

/// Group `group` placed (and perhaps moved) by a transform.
struct AccelInstance {
    int group = 0;
    AnimatedTransform renderFromObject;
};

/// Acceleration structure over all shapes. Thread-safe after construction.
class Accelerator {
  public:
    /// @param groups     geometries; groups[0] is in rendering space, the others in their objects' space
    /// @param instances  placements of groups 1.. in rendering space
    Accelerator(const std::vector<std::vector<AccelGeometry>>& groups, std::vector<AccelInstance> instances);
    ~Accelerator();
    Accelerator(const Accelerator&) = delete;
    Accelerator& operator=(const Accelerator&) = delete;

    /// Nearest hit with 0 < t < tMax. Alpha holes are passed through: with alpha in (0,1) a hit counts with
    /// that probability, by a hash of the ray, the primitive and the hit.
    bool Intersect(const Ray& ray, float tMax, Hit* hit) const;
    /// True if anything is hit with 0 < t < tMax.
    bool Occluded(const Ray& ray, float tMax) const;
    Bounds3 Bounds() const;
    /// Bytes that the structure itself takes.
    size_t MemoryBytes() const;

  private:
    struct Implementation;
    std::unique_ptr<Implementation> impl_;
};

/// True if a ray passes through the hole that `alpha` makes at this hit.
bool PassesAlpha(const FloatTexture& alpha, const Shape& shape, const Ray& ray, const ShapeHit& hit,
                 int primitive);

}  // namespace lacquer
