// Damage of the headers of OpenEXR files, on which the library would waste memory.
#pragma once

#include <string>

namespace lacquer {

/// What is wrong with the headers of an OpenEXR file: attributes that are longer than the file, or whose
/// values do not end where the header says. Empty if nothing is. Reads the headers once, in bounded memory.
///
/// OpenEXR reserves what an attribute claims to need before it finds that the file is shorter, and reads
/// values of known types without regard for their claimed size: what follows is then read from elsewhere, and
/// any four bytes of the file may be taken for the length of a text.
std::string ExrHeaderDamage(const std::string& path);

}  // namespace lacquer
