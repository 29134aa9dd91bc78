// Damage of image files that the libraries would miss, print, or waste much memory on.
#pragma once

#include <string>

namespace lacquer {

/// What is wrong with the frame of a file of the given format ("png", "jpeg", "openexr", "gif"; others are
/// not looked at): truncation, a wrong checksum, a size that does not fit. Empty if nothing is found. Reads
/// the file once, in bounded memory (JPEG: as much as the file).
std::string FileDamage(const std::string& path, const std::string& format);
/// The same for the pixels of a file in which FileDamage() finds nothing ("png"; others are not looked at),
/// to be asked when their number is known to be acceptable.
std::string PixelDamage(const std::string& path, const std::string& format);

}  // namespace lacquer
