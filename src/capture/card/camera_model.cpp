#include "capture/card/camera_model.h"

namespace lacquer::capture {

Eigen::Vector2d ProjectPoint(const Intrinsics& intrinsics, const CameraPose& pose,
                             const Eigen::Vector3d& point) {
    const Eigen::Vector3d p = pose.ToCamera(point);
    double x = p.x() / p.z(), y = p.y() / p.z();
    Distort(intrinsics.k1, intrinsics.k2, &x, &y);
    return {intrinsics.f * x + intrinsics.cx, intrinsics.f * y + intrinsics.cy};
}

}  // namespace lacquer::capture
