// The image that others are measured against, and what is known of its own noise.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pbrt/image/image.h"

namespace lacquer::compare {

/// A reference. Its noise is known where it was rendered in parts: then `image` has the channels of
/// NoiseChannels() behind R, G and B.
struct Reference {
    Image image;
    std::string renderedBy;      ///< label of the candidate; empty: not known
    double samplesPerPixel = 0;  ///< 0: not known
    bool NoiseIsKnown() const;
};

/// "MeanVariance.R", ".G", ".B" and ".Y": the variance of the reference's value itself, that is of a mean, in
/// each colour and in luminance.
const std::vector<std::string>& NoiseChannels();

/// Averages independent renders of one scene and adds the noise of their mean, from how they differ: for n
/// parts, the sample variance over n, with n - 1 degrees of freedom in each pixel.
/// @param parts    of one size, in R, G, B, with equally many samples each; at least two
Reference ReferenceOfParts(const std::vector<Image>& parts);

/// An image file as reference, converted into the colour space of `like`. Its noise stays known unless that
/// changes it.
/// Errors: FileError unless it is a finite RGB image of the pixels of `like`, or of its full frame, which is
/// cut.
Reference ReadReference(const std::string& path, const Image& like);

}  // namespace lacquer::compare
