// Files of named tensors: safetensors, which is a header in JSON and numbers behind it.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <vector>

#include "pbrt/core/file_bytes.h"

namespace lacquer {

/// "2 x 3"; empty for a single number.
std::string TensorShapeText(std::span<const size_t> shape);

/// The tensors of a file, read as they are asked for.
class SafetensorsFile {
  public:
    /// Errors: FileError, if the file cannot be read, is not of this kind, or has a header that is cut off,
    /// longer than 16 MiB, nested like no header, or that names a tensor twice, gives one more than 16
    /// dimensions, places one beyond the end or over another, or leaves more bytes at the end. The header is
    /// looked at before the numbers are read.
    explicit SafetensorsFile(const std::string& path);

    const std::string& Path() const { return path_; }
    bool Has(const std::string& name) const { return entries_.contains(name); }
    /// In alphabetical order.
    std::vector<std::string> Names() const;
    /// Errors: FileError if there is none.
    const std::vector<size_t>& ShapeOf(const std::string& name) const { return Find(name).shape; }
    /// What the header says besides tensors; values that are no text are left out.
    const std::map<std::string, std::string>& Metadata() const { return metadata_; }

    /// Numbers of a tensor, the last index fastest; float32 or float16.
    /// Errors: FileError that names the tensor, if there is none, it has another shape or type, or some of
    /// its numbers are not finite.
    std::vector<float> Read(const std::string& name, std::span<const size_t> shape) const;

  private:
    struct Entry {
        std::string type;
        std::vector<size_t> shape;
        size_t begin = 0, end = 0;  ///< bytes behind the header
    };
    /// @param start     of the file: its first eight bytes, or fewer if it has no more
    /// @param numBytes  of the whole file
    size_t HeaderLength(std::string_view start, size_t numBytes) const;
    /// @param numBytes  behind the header
    void ReadHeader(std::string_view header, size_t numBytes);
    Entry ReadEntry(const std::string& name, const nlohmann::json& value, size_t numBytes) const;
    void CheckPlaces(size_t numBytes) const;
    const Entry& Find(const std::string& name) const;
    std::vector<float> Decode(const Entry& entry, size_t count) const;

    std::string path_;
    FileBytes bytes_;
    std::string_view numbers_;
    std::map<std::string, Entry> entries_;
    std::map<std::string, std::string> metadata_;
};

struct NamedTensor {
    std::string name;
    std::vector<size_t> shape;
    std::vector<float> values;  ///< as many as the shape says, the last index fastest
};

/// Writes float32, or float16 where `half` asks for it. The bytes depend on the arguments only.
/// Errors: FileError.
void WriteSafetensors(const std::string& path, std::span<const NamedTensor> tensors,
                      const std::map<std::string, std::string>& metadata, bool half = false);

}  // namespace lacquer
