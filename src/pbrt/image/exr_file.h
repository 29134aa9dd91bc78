// OpenEXR files, by the OpenEXR library alone: they are what renders are written to, and OpenImageIO takes
// longer to load than a small render.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "pbrt/image/image_library.h"

namespace lacquer {

/// Opens the first part of a file; its values are read as floats only. Channels are in the order of their
/// layers, each with R, G, B, A first; attributes have OpenImageIO's names where those differ ("DateTime").
/// Values of 32-bit integers become the nearest floats. Errors: std::exception with what is wrong with the
/// file; subsampled channels are not supported.
std::unique_ptr<ImageReader> OpenExr(const std::string& path);

/// The bytes of a file with losslessly packed scanlines: the same for the same image, without a date of their
/// own.
/// @param contents  channels are of type Half or Float
/// @param values  those of a pixel after each other, rows from the top
/// Errors: std::exception with what cannot be written.
std::vector<unsigned char> EncodeExr(const ImageContents& contents, const float* values);

}  // namespace lacquer
