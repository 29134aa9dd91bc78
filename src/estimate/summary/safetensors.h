// Files of named tensors: safetensors, which is a header in JSON and numbers behind it.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "pbrt/core/file_bytes.h"

namespace lacquer::estimate {

/// The tensors of a file, read as they are asked for.
class TensorFile {
  public:
    /// Errors: FileError, if the file cannot be read, is not of this kind, or has a header that is cut off,
    /// longer than 16 MiB, or places tensors beyond the end.
    explicit TensorFile(const std::string& path);

    /// Numbers of a tensor, the last index fastest; float32 or float16.
    /// Errors: FileError that names the tensor, if there is none, or it has another shape or type.
    std::vector<float> Read(const std::string& name, std::span<const size_t> shape) const;

  private:
    struct Entry {
        std::string type;
        std::vector<size_t> shape;
        size_t begin = 0, end = 0;  ///< bytes behind the header
    };
    void ReadHeader(std::string_view header);

    std::string path_;
    FileBytes bytes_;
    std::string_view numbers_;
    std::map<std::string, Entry> entries_;
};

}  // namespace lacquer::estimate
