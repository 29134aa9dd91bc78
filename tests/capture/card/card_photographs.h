// Photographs of a card by a projector of the tests' own: every ray is known, and so is all that is wrong.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "capture/card/camera_model.h"
#include "capture/card/usable_tags.h"
#include "pbrt/image/image.h"

namespace lacquer::capture::test_cards {

/// A pose from which the camera looks at a point of the card. @param rollDeg  clockwise turn of the camera
CameraPose LookAtCard(const Eigen::Vector3d& position, const Eigen::Vector2d& target = {0, 0},
                      double rollDeg = 0);
/// Nine positions about 25 cm above a card of 17 cm, some 5 to 12 cm to the sides, turned a little.
std::vector<CameraPose> NinePoses();

/// A card and a sample in its window, by cells: four for each unit of the card.
struct PhotographedCard {
    PhotographedCard();
    double size = 17;  ///< [cm]
    Image cells;       ///< of CardImage(size, 4)
    /// Of the plane of the sample, in cm; it shows in the window's square of kSampleShare.
    std::function<double(double x, double y)> sample = [](double, double) { return 0.4; };
    double depth = 0;  ///< of the sample [cm]
    /// Height of the card's middle over its left and right sides, as a parabola [cm].
    double bend = 0;
    double aspect = 1;  ///< its height is that many times its width

    /// Puts the tag of `id` (of the family) at the place of tag `place`.
    void PutTag(int place, int id);
    void Cover(int place);  ///< grey instead of a tag
    void Mirror();
};

struct Photographer {
    Int2 resolution{640, 512};
    Intrinsics intrinsics{605, 320, 256, 0, 0};
    double exposure = 0.7;    ///< value of white straight under the camera
    double vignetting = 0.5;  ///< of the light, at the corners
    double noise = 0.01;      ///< standard deviation, of linear values
    int samplesPerEdge = 5;   ///< rays for each pixel, squared
};

/// Linear values in one channel, means over the areas of pixels, without noise.
Image TakePhotograph(const PhotographedCard& card, const Photographer& photographer, const CameraPose& pose);
/// A photograph without distortion as a lens with some would have taken it: channel by channel, bilinearly.
Image Distorted(const Image& image, const Intrinsics& straight, const Intrinsics& bent);
/// Adds noise.
Image WithNoise(Image image, double deviation, uint64_t seed);

/// The tags of photographs, named p0, p1, ...
std::vector<CardPhotograph> Detect(const std::vector<Image>& photographs);
/// Photographs with the noise of `photographer` from all poses.
std::vector<CardPhotograph> TakeAndDetect(const PhotographedCard& card, const Photographer& photographer,
                                          const std::vector<CameraPose>& poses, uint64_t seed);

}  // namespace lacquer::capture::test_cards
