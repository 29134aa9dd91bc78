// Tags of family 36h11 [Olson 2011]: what they look like, and where they are in a photograph.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "pbrt/image/image.h"

namespace lacquer::capture {

inline constexpr int kTagCells = 8;  ///< along an edge of the black square
/// Row by row from the top; true is black.
using TagCells = std::array<bool, size_t(kTagCells) * kTagCells>;
/// @param id  of the family, from 0
TagCells CellsOfTag(int id);

struct DetectedTag {
    int id = 0;
    /// In the order of TagCorner(): as the tag sees it, lower left, lower right, upper right, upper left.
    /// Pixels, (0,0) is the outer corner of the top left one.
    std::array<Eigen::Vector2d, 4> corners;
};

/// What a photograph shows of a card.
struct TagDetection {
    std::vector<DetectedTag> tags;  ///< of the card, each once, by id
    std::vector<int> twice;    ///< ids of the card that were seen more than once; they are not among `tags`
    std::vector<int> unknown;  ///< ids that no card has
    /// Ids of the card that were not seen.
    std::vector<int> Missing() const;
};

/// Means of the colours, in one channel.
Image GreyOf(const Image& image);

/// Finds the tags of a card. Corners are where straight lines along the edges meet, good to some hundredths
/// of a pixel where lenses bend them little. @param grey  one channel of linear values: edges of encoded ones
/// lie towards the black side, since an encoding makes pixels that are half covered brighter
TagDetection DetectTags(const Image& grey);

}  // namespace lacquer::capture
