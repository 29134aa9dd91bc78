// Where the cameras stood that took photographs of a card, and what kind of camera it was.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "capture/card/camera_model.h"
#include "capture/card/usable_tags.h"

namespace lacquer::capture {

struct CalibrationOptions {
    double size = 17;    ///< of the card [cm]
    Int2 resolution{0};  ///< of all photographs
    /// Focal length that is known [pixels]: it is not estimated.
    std::optional<double> focal = {};
    /// That of the files' metadata [pixels]. It counts for one or two photographs, which tell too little of
    /// it; of more it is where the search starts, and bounds them weakly.
    std::optional<double> focalOfMetadata = {};
    /// What may remain of the tags of a photograph, root mean square over corners [pixels].
    double maxRms = 2;
};

/// One photograph, as the calibration explains it.
struct PhotographPose {
    CameraPose pose;
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of the position [cm^2]
    double rms = 0;  ///< distance of corners from where they should be, root mean square [pixels]
    std::vector<DetectedTag> tags;       ///< that count
    std::vector<DetectedTag> projected;  ///< the same tags where the camera should see them
    std::vector<int> rejected;           ///< ids of tags that are not where the card has them
    /// Standard errors of the position [cm].
    Eigen::Vector3d PositionError() const { return covariance.diagonal().cwiseSqrt(); }
};

struct Calibration {
    Intrinsics intrinsics;
    double focalError = 0;  ///< standard error of f [pixels]
    double rms = 0;         ///< over all corners [pixels]
    std::vector<PhotographPose> photographs;
    std::vector<std::string> warnings;  ///< each a sentence without its full stop
};

/// Finds camera and poses, by homographies first, then by least squares over all corners [Zhang 2000].
///
/// Of three and more photographs, f, the principal point, k1 and k2 are estimated; of fewer ones f is that of
/// `options`, the principal point is in the middle, and there is no distortion. Tags that are not where the
/// card has them, for their own or for a wrong id, do not count. Photographs that lack tags count as long as
/// the others surround the window (usable_tags.h).
///
/// Standard errors are those of least squares, with the variance of residuals; f (10 % about that of
/// metadata, or 50 % about four fifths of the longer side), principal point (2 % of the diagonal), k1 and k2
/// (0.3) have weak priors, which keep them in bounds where photographs tell nothing of them. Of fewer than
/// three photographs, errors contain what is not known of the camera: 3 % of f where it is of metadata, 2 %
/// of the diagonal for the principal point, 0.03 for k1. A card of another size than `options` say has all
/// positions in proportion wrong, and nothing shows it.
///
/// Errors: SceneErrors, one for each photograph that cannot be used, with its name as the place: no tags,
/// tags that are seen twice, tags that lack, tags in another order than the card's, mirrored ones; SceneError
/// where there are no photographs, f is not known or cannot be found, or the card is not flat.
Calibration Calibrate(std::span<const CardPhotograph> photographs, const CalibrationOptions& options);

}  // namespace lacquer::capture
