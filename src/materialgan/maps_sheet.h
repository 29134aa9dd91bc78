// Maps side by side as an image to look at.
#pragma once

#include "capture/maps.h"
#include "pbrt/image/image.h"

namespace lacquer::materialgan {

/// Rows of materials of one size; of each the albedo, normal, roughness, specular albedo and a photograph
/// with flash, one below the other. Linear values, for files that store them as sRGB.
/// @param rows  of the same length, not empty
Image MapsSheet(const std::vector<std::vector<capture::Maps>>& rows);

}  // namespace lacquer::materialgan
