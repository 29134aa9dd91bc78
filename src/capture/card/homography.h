// Homographies between the card and photographs, and what they tell of cameras without distortion.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "capture/card/camera_model.h"
#include "capture/card/tags.h"

namespace lacquer::capture {

/// The homography that takes `from` to `to`, as nearly as it can: the normalised direct linear transform
/// [Hartley and Zisserman 2004, alg. 4.2]. Its lower right number is 1. @param from, to  of one length, at
/// least 4
Eigen::Matrix3d FitHomography(std::span<const Eigen::Vector2d> from, std::span<const Eigen::Vector2d> to);

/// Tags that lie as on a card, by one homography from it [cm] to pixels, and that homography.
struct CardHomography {
    Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
    std::vector<size_t> consistent;  ///< indices of tags
};
/// The largest set of tags that agree with the card up to half of a tag's edge, which distortion does not
/// reach: a homography through every pair of them is tried. @param size  of the card [cm]
CardHomography FindCard(std::span<const DetectedTag> tags, double size);

/// The focal length that makes all of the homographies images of a plane by one camera, by least squares of
/// the constraints of [Zhang 2000, sec. 3.1] with square pixels and a known principal point. Empty if there
/// is none: views from straight above say nothing of it. @param center  principal point [pixels]
/// @param scale  about the focal length [pixels]
std::optional<double> FocalLengthOf(std::span<const Eigen::Matrix3d> homographies,
                                    const Eigen::Vector2d& center, double scale);

/// The pose of a camera of which the homography from the plane z = 0 is known [Zhang 2000, sec. 3.1]; its
/// position has a negative z if the card is mirrored.
CameraPose PoseOf(const Eigen::Matrix3d& homography, const Intrinsics& intrinsics);

}  // namespace lacquer::capture
