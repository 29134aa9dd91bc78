// Tags of photographs that lie as the card has them; the rest is an error or does not count.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "capture/card/homography.h"
#include "capture/card/tags.h"

namespace lacquer::capture {

/// The tags of one photograph.
struct CardPhotograph {
    std::string name;  ///< for messages
    TagDetection detection;
};

/// Photographs with fewer tags than this do not count, nor do those that show none of the three tags around
/// some corner of the card: [Guo 2021] ask for all sixteen, but eight that surround the window make
/// the error of a position not even twice as large, and what they say is in the standard errors.
inline constexpr size_t kMinTags = 8;
bool SurroundTheWindow(std::span<const DetectedTag> tags);

struct UsableTags {
    std::vector<DetectedTag> tags;
    std::vector<int> rejected;  ///< ids of tags that are not where the card has them
    Eigen::Matrix3d homography = Eigen::Matrix3d::Identity();  ///< from the card [cm] to pixels
};

/// @param size  of the card [cm]
/// @param warnings  gets one for each photograph that lacks tags, or has wrong ones
/// Errors: SceneErrors with one for each photograph that cannot be used, its name as the place.
std::vector<UsableTags> FindUsableTags(std::span<const CardPhotograph> photographs, double size,
                                       std::vector<std::string>* warnings);

/// "1, 2 and 3".
std::string ListOfIds(const std::vector<int>& ids);

}  // namespace lacquer::capture
