// The text of a scene file, read and unpacked.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include "pbrt/core/error.h"

namespace lacquer {

struct Source {
    std::string name;       ///< in messages
    std::string_view text;  ///< lives as long as `memory`
    std::string key;        ///< the same for all paths of one file; empty where the text is from no file
    std::shared_ptr<const void> memory;  ///< of the text
};

/// Largest text that is read, after inflation.
inline constexpr size_t kMaxSourceBytes = size_t(1) << 29;

/// A text that is no file.
Source SourceOf(std::string name, std::string text);

/// Reads a file into memory; gzip data is inflated.
/// @param loc  the directive that names the file; without one, it is from the command line and may be a pipe
/// Errors: FileError at `loc` if it cannot be read or is larger than `limit`; SceneError at `loc` for damaged
/// gzip
///         data, or none in spite of the name's ".gz", and in the file itself if it holds other than text.
Source ReadSource(const std::string& path, const FileLoc& loc = {}, size_t limit = kMaxSourceBytes);
/// SceneError for a byte-order mark, a NUL byte, or many control characters.
void RejectOtherThanText(const Source& source);

}  // namespace lacquer
