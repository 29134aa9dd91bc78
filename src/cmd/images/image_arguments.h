// What the commands on images share.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "compare/box.h"
#include "pbrt/core/progress.h"
#include "pbrt/image/image.h"

namespace lacquer::cmd {

/// Reads an image that the command line names. Errors: FileError, also where the file is damaged.
/// @param encoding  of 8- and 16-bit PNG values
Image ReadImageArgument(const std::string& path, ColorEncoding encoding = {ColorEncoding::Kind::SRGB, 1});

/// The arguments `image`, `images ...` and `--outfile` of most commands; all are required.
void AddImage(CLI::App& app, std::string& path);
void AddImageList(CLI::App& app, std::vector<std::string>& paths, const char* description);
void AddOutfile(CLI::App& app, std::string& path);
/// Errors: usage, where two files to write are one. @param option  that names `path`; empty paths are none
void CheckDifferent(const char* option, const std::string& path, const std::string& outfile);
/// `--channels A,B`, and the indices of those; of all channels where none are given. Errors: usage, with the
/// nearest name.
void AddChannels(CLI::App& app, std::vector<std::string>& names);
std::vector<int> ChannelsOf(const Image& image, const std::vector<std::string>& names);
/// Errors: FileError for an image with neither R, G and B nor Y.
void RequireColors(const Image& image, const std::string& path);
/// Formats for screens hold bytes, all others floats.
bool HoldsBytes(const std::string& path);
/// The last lines of their help.
inline constexpr const char* kImageStatus = R"(
Exit status: 0 all is done; 1 wrong usage; 3 a file cannot be read or written, or does not fit.)";

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
