// Damage of PNG files. libpng would find the same, but it prints what it finds.
#pragma once

#include <string>

namespace lacquer {

/// What is wrong with the chunks of a PNG file: truncation, wrong checksums in what must be understood, a
/// header that makes no sense, chunks missing or out of order. Empty if nothing is. Reads the file once, in
/// bounded memory.
std::string PngChunkDamage(const std::string& path);
/// What is wrong with the compressed pixels of a PNG file whose chunks are sound: damaged or missing data, an
/// unknown row filter. Empty if nothing is. Unpacks the pixels once, in bounded memory.
std::string PngPixelDamage(const std::string& path);

}  // namespace lacquer
