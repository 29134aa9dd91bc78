// PNG files, by libpng alone: most textures are such files, and OpenImageIO takes longer to load than to read
// one.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "pbrt/image/image_library.h"

namespace lacquer {

/// Opens a file whose chunks are sound (PngChunkDamage); its values are read only as the type that they have,
/// bytes or 16-bit integers. Palettes, fewer bits and transparent colours become the channels that they stand
/// for; colours are as they are in the file, whatever its gamma. Rows are read in their order, and once.
/// Attributes are the file's first texts (of up to 1 MiB), date and size of pixels, those that image formats
/// have in common under OpenImageIO's names ("ImageDescription"). Null for files with Exif or XMP, which
/// OpenImageIO understands. Errors: std::exception with what is wrong with the file.
std::unique_ptr<ImageReader> OpenPng(const std::string& path);

/// The bytes of a file of sRGB colours: the same for the same image. Strings among the attributes become
/// texts (of up to 1 MiB), but for those of how another file is stored; date and size of pixels are kept.
/// @param contents  one to four channels of type UInt8
/// @param values  those of a pixel after each other, rows from the top
/// Errors: std::exception with what cannot be written.
std::vector<unsigned char> EncodePng(const ImageContents& contents, const unsigned char* values);

}  // namespace lacquer
