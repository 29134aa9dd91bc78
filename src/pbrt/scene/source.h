// The text of a scene file, read and unpacked.
#pragma once

#include <cstddef>
#include <string>

namespace lacquer {

struct Source {
    std::string name;  ///< in messages
    std::string text;
    std::string key;  ///< the same for all paths of one file; empty where the text is from no file
};

/// Largest text that is read, after inflation.
inline constexpr size_t kMaxSourceBytes = size_t(1) << 30;

/// Reads a file into memory; a name that ends in ".gz" is inflated.
/// Errors: FileError if it cannot be read, is larger than `limit`, or is no gzip data;
///         SceneError for a byte-order mark, at the file's first character.
Source ReadSource(const std::string& path, size_t limit = kMaxSourceBytes);
/// SceneError if the text begins with a byte-order mark.
void RejectByteOrderMark(const Source& source);

}  // namespace lacquer
