// What the commands on images (diff, convert, merge, info) share.
#pragma once

#include <optional>
#include <string>

#include "compare/box.h"
#include "pbrt/core/progress.h"
#include "pbrt/image/image.h"

namespace lacquer::cmd {

/// Reads an image that the command line names; 8- and 16-bit PNG values are taken as sRGB. Errors: FileError,
/// also where the file is damaged.
Image ReadImageArgument(const std::string& path);

/// A box of the full frame, cut to the image's pixels and counted from their corner. Errors: usage
/// (CLI::ValidationError) for text that is no box, and for a box without a pixel of the image.
/// @param option  as on the command line: "--box"
compare::Box BoxOfImage(const char* option, const std::string& text, const Image& image);

/// Why two images cannot be taken together pixel by pixel: size, place in the frame, colour space. Empty if
/// they can. Says "it" for the second image.
std::string Mismatch(const Image& first, const Image& second);
/// The same about their channels, in any order. @param ignored  a channel that may be missing in either
std::string ChannelMismatch(const Image& first, const Image& second, const std::string& ignored = "");

/// Tells the observer how many values of `image`, which is called `name`, are NaN or infinite, if any are.
void WarnOfNonFinite(const Image& image, const std::string& name, Observer* observer);

/// A whole number of the metadata, empty if it is not there.
std::optional<int> IntMetadata(const Image& image, const std::string& name);

}  // namespace lacquer::cmd
