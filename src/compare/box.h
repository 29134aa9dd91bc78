// Named parts of an image: where noise is measured.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "pbrt/core/vec.h"

namespace lacquer::compare {

/// A rectangle of pixels with a name; never empty.
struct Box {
    std::string name;
    Bounds2i pixels;  ///< in the full image; the end is not included
};

/// Reads "NAME:x0,x1,y0,y1" (or without a name, which makes it "box"). Four numbers from 0 to 1 are fractions
/// of the image's width and height, rounded to the nearest pixel edges; anything else counts pixels. x0 and
/// y0 belong to the box, x1 and y1 do not. Errors: std::invalid_argument with a message for people: not of
/// this form, or no pixel of the image.
Box ParseBox(const std::string& text, Int2 resolution);

/// The boxes that a scene file suggests by lines "# box NAME x0 x1 y0 y1" (fractions) before its first
/// directive. Lines that are no boxes are comments. None if the file cannot be read.
std::vector<Box> BoxesOfScene(const std::string& path, Int2 resolution);
std::vector<Box> BoxesOfScene(std::istream& scene, Int2 resolution);

/// The whole image, called "all".
Box WholeImage(Int2 resolution);

}  // namespace lacquer::compare
