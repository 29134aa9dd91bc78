// Images of all directions: how they lie on their plane, and the equal-area form that lights use.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pbrt/image/image.h"

namespace lacquer {

/// How an image shows all directions. z is up; the middle of an image is towards -x, except for EqualArea.
enum class EnvironmentMapping {
    EqualArea,   ///< a square, octahedral [Clarberg 2008]: +z in the middle, -z at the corners
    LatLong,     ///< phi / (2 pi) to the right from +x over +y, theta / pi downward from +z
    MirrorBall,  ///< the photograph of a mirroring ball by a camera far away on -x; the ball fills the square
    Angular,     ///< "light probe": the angle to -x over pi is the distance from the middle of the disk
};
/// "equalarea", "latlong", "mirrorball", "angular", in this order.
std::vector<std::string> EnvironmentMappingNames();
/// Errors: std::out_of_range for another name.
EnvironmentMapping EnvironmentMappingOf(const std::string& name);

/// Why an image of this size cannot have the mapping, empty if it can: all but LatLong are square.
std::string WhyNotOfMapping(Int2 resolution, EnvironmentMapping mapping);

/// Where a unit direction is in an image, in [0,1]^2 from its top left corner. MirrorBall and Angular show
/// the direction away from the camera on their whole rim.
Point2 DirectionToImage(EnvironmentMapping mapping, Vec3 w);

/// A side of the equal-area image with as many pixels as this one, where the disk of a ball counts alone; at
/// most 8192.
int EqualAreaSide(Int2 resolution, EnvironmentMapping mapping);
/// The image in the equal-area mapping: each pixel is the mean of bilinear look-ups, at least four in each
/// direction for a pixel of the image, so that small suns keep their energy. Channels and colour space stay.
/// @param side  >= 1
/// Cost: about 0.1 s for a megapixel on two cores.
Image ToEqualArea(const Image& image, EnvironmentMapping mapping, int side);

}  // namespace lacquer
