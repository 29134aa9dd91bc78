// What perspective and orthographic cameras share: the screen window, rasterisation and the thin lens.
#pragma once

#include "pbrt/base/camera.h"
#include "pbrt/core/sampling.h"

namespace lacquer {

class ProjectiveCamera : public Camera {
  public:
    Transform CameraFromRaster() const override { return cameraFromRaster_; }
    std::optional<Transform> ScreenFromCamera() const override { return screenFromCamera_; }
    std::optional<Point2> RasterOf(Vec3 pCamera, bool isDirection) const override;
    std::string WhyNoRaster() const override { return {}; }

    bool ReadsLens() const override { return HasLens(); }

  protected:
    /// @param screenFromCamera  projection to the screen, on which the shorter image axis spans [-1, 1]
    ProjectiveCamera(const CameraArgs& args, const Transform& screenFromCamera);

    /// Moves the origin of a pinhole ray onto the lens so that it still meets its point in the plane of
    /// focus. Directions need no length.
    void ApplyLens(Point2 pLens, Point3* origin, Vec3* direction) const {
        const Point2 onLens = lensRadius_ * SampleUniformDiskConcentric(pLens);
        const Point3 focus = *origin + *direction * (focalDistance_ / direction->z);
        *origin += Vec3(onLens.x, onLens.y, 0);
        *direction = focus - *origin;
    }
    bool HasLens() const { return lensRadius_ > 0; }
    /// The ray and its neighbours from camera space to rendering space, where directions are made unit.
    std::optional<CameraRay> ToRenderSpace(const Point3 origins[3], const Vec3 directions[3],
                                           float time) const;

    Transform screenFromCamera_, cameraFromRaster_;
    Vec3 dxCamera_, dyCamera_;  ///< camera-space step of one pixel on the near plane
    float lensRadius_, focalDistance_;
};

}  // namespace lacquer
