// How large a texture footprint is: the change of a surface point from one pixel to the next.
#pragma once

#include "pbrt/base/camera.h"
#include "pbrt/base/interaction.h"

namespace lacquer {

/// Footprints at first hits from the neighbouring rays, elsewhere from the camera's smallest pixel.
class FootprintEstimator {
  public:
    /// @param scale  part of a pixel that one sample stands for: max(1/8, 1/sqrt(samples per pixel))
    FootprintEstimator(const Camera& camera, Int2 resolution, float scale);

    /// At the first hit of a camera ray: meets the neighbouring rays with the tangent plane.
    void AtFirstHit(const CameraRay& ray, SurfaceInteraction* si) const;
    /// At later hits: as if the camera saw the point with its narrowest pixel.
    void ApproximateFootprint(SurfaceInteraction* si) const;

  private:
    void Set(Vec3 dpdx, Vec3 dpdy, SurfaceInteraction* si) const;

    const Camera* camera_;
    float scale_;
    float minPosition_ = 0;   ///< smallest origin step of a pixel
    float minDirection_ = 0;  ///< smallest direction step of a pixel
};

}  // namespace lacquer
