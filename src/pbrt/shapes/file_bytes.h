// A whole file in memory, unzipped if need be.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <string>

#include "pbrt/core/error.h"

namespace lacquer {

/// Bytes of a file. Not initialised before they are read, so that no page is touched twice.
struct FileBytes {
    struct Free {
        void operator()(char* p) const { std::free(p); }
    };
    std::unique_ptr<char, Free> data;
    size_t size = 0;
};

/// Reads the file at `path`; gzip is known by its first bytes, whatever the name.
/// Errors: FileError at `loc` if it cannot be read, is no regular file, or has more than `maxBytes`
/// (unzipped); SceneError at `loc` for damaged gzip data.
FileBytes ReadFileBytes(const std::string& path, const FileLoc& loc, size_t maxBytes);

}  // namespace lacquer
