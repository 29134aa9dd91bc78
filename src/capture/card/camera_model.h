// From points on the card to pixels: a pinhole with radial distortion [Zhang 2000].
#pragma once

#include <Eigen/Core>

namespace lacquer::capture {

/// One camera at one zoom and focus. Pixels are square; (0,0) is the outer corner of the top left one.
struct Intrinsics {
    double f = 0;           ///< focal length [pixels]
    double cx = 0, cy = 0;  ///< principal point [pixels]
    /// Of the factor 1 + k1 r^2 + k2 r^4, r the tangent of the angle to the axis.
    double k1 = 0, k2 = 0;
};

/// Where a camera stood, in the frame of the card.
struct CameraPose {
    /// From the frame of the card to that of the camera: x to the right, y down, z in the direction of view.
    Eigen::Matrix3d rotation = Eigen::Vector3d(1, -1, -1).asDiagonal();
    Eigen::Vector3d position{0, 0, 1};  ///< [cm]

    Eigen::Vector3d ToCamera(const Eigen::Vector3d& point) const { return rotation * (point - position); }
};

/// Applies the distortion to the point x, y of the plane at z = 1, in place; T is a number, or one that
/// carries derivatives.
template <class T>
void Distort(const T& k1, const T& k2, T* x, T* y) {
    const T r2 = *x * *x + *y * *y;
    const T factor = T(1) + r2 * (k1 + r2 * k2);
    *x *= factor;
    *y *= factor;
}

/// Where a camera sees a point of the card's frame [pixels]. The point is in front of it.
Eigen::Vector2d ProjectPoint(const Intrinsics& intrinsics, const CameraPose& pose,
                             const Eigen::Vector3d& point);

}  // namespace lacquer::capture
