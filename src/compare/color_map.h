// Errors as colours.
#pragma once

#include <vector>

#include "pbrt/image/image.h"

namespace lacquer::compare {

/// An image of errors: 0 is black, `largest` and more pale yellow, by the map "magma", whose brightness rises
/// evenly. What is not finite is pure green, which the map does not have. Linear sRGB.
/// @param errors   one for each pixel, rows from the top
/// @param largest  0: all is black
Image ColoredErrors(const std::vector<float>& errors, Int2 resolution, float largest);

}  // namespace lacquer::compare
