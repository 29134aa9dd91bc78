// A whole file in memory, unzipped if need be: how every file that is read as a whole is read.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>

#include "pbrt/core/error.h"

namespace lacquer {

/// Bytes of a file. Not initialised before they are read, so that no page is touched twice.
struct FileBytes {
    struct Free {
        void operator()(char* p) const { std::free(p); }
    };
    std::unique_ptr<char, Free> data;
    size_t size = 0;
    bool wasZipped = false;
    std::string_view View() const { return {data.get(), size}; }
};

/// What ReadFileBytes() takes.
struct ReadLimits {
    size_t maxBytes;          ///< of the file, and of what it unzips to
    bool regularOnly = true;  ///< no pipes and devices, which may never end, or never begin
    const char* advice = "";  ///< ends the message about a file that is too large
};

/// Reads the file at `path`; gzip is known by its first bytes, whatever the name. What unzips to more than
/// 256 MB and 200 times its size counts as too large.
/// Errors: FileError at `loc` if it cannot be read, is of another kind, or is larger than the limit;
/// SceneError at `loc` for damaged gzip data.
FileBytes ReadFileBytes(const std::string& path, const FileLoc& loc, const ReadLimits& limits);

/// The first `count` bytes of a regular file as they are, or all if it has fewer. Errors: FileError at `loc`.
std::string ReadFirstBytes(const std::string& path, const FileLoc& loc, size_t count);

}  // namespace lacquer
