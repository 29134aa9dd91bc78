// Files of named arrays: the container of measured BRDFs.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "pbrt/core/file_bytes.h"

namespace lacquer {

/// An array of floats; the last index runs fastest.
struct FloatTensor {
    std::vector<size_t> shape;
    std::vector<float> values;
};

/// A file of named arrays, in the format of the RGL material database [Dupuy and Jakob 2018]:
/// "tensor_file\0", two bytes of version (1.0), u32 number of fields; for each field u16 length of its name,
/// the name, u16 number of dimensions, u8 type, u64 offset of its data in the file, u64 for each dimension.
/// All little-endian.
class TensorFile {
  public:
    /// Reads the file and checks that every field lies within it.
    /// Errors: FileError at `loc` if it cannot be read; SceneError at `loc`, with the file, the offset and
    /// the field, for what is no such file, or a damaged one.
    TensorFile(const std::string& path, const FileLoc& loc);

    /// A field of 32-bit floats with that number of dimensions, all values finite. Errors: SceneError that
    /// says what the field is instead.
    FloatTensor Floats(std::string_view name, size_t dimensions) const;
    /// A field of one dimension of bytes.
    std::string_view Bytes(std::string_view name) const;
    /// SceneError at the place that names this file: "file": field "name": message.
    [[noreturn]] void Fail(std::string_view field, const std::string& message) const;

  private:
    struct Field {
        std::string name;
        int type = 0;
        std::vector<size_t> shape;
        size_t offset = 0, numValues = 0;
    };
    const Field& Find(std::string_view name, int type, size_t dimensions) const;

    std::string path_;
    FileLoc loc_;
    FileBytes file_;
    std::vector<Field> fields_;
};

}  // namespace lacquer
