// The header of a PLY file: what elements it holds and how.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "pbrt/core/error.h"

namespace lacquer {

/// Where a PLY file's text is wrong: turns into a SceneError at the place in the scene that names the file.
class PlyContext {
  public:
    PlyContext(std::string path, FileLoc loc) : path_(std::move(path)), loc_(loc) {}
    /// "path:line: message".
    [[noreturn]] void FailAtLine(int64_t line, const std::string& message) const;
    /// "path: byte offset: message".
    [[noreturn]] void FailAtByte(size_t offset, const std::string& message) const;
    [[noreturn]] void Fail(const std::string& message) const;
    const std::string& Path() const { return path_; }

  private:
    std::string path_;
    FileLoc loc_;
};

enum class PlyType : unsigned char { Int8, UInt8, Int16, UInt16, Int32, UInt32, Float32, Float64 };
size_t PlyTypeSize(PlyType type);

struct PlyProperty {
    std::string name;
    PlyType type = PlyType::Float32;     ///< of the value, or of the items of a list
    std::optional<PlyType> countType{};  ///< lists only
};

struct PlyElement {
    std::string name;
    int64_t count = 0;
    int64_t line = 0;  ///< of the header, for messages
    std::vector<PlyProperty> properties;
};

struct PlyHeader {
    enum class Format { Ascii, LittleEndian, BigEndian };
    Format format = Format::Ascii;
    std::vector<PlyElement> elements;
    size_t size = 0;  ///< offset of the first byte of data
    int64_t numLines = 0;
};

/// Parses the header at the start of `bytes`, and checks that the rest can hold as many elements as it
/// declares (before anyone allocates them). Errors: SceneError with the header's line.
PlyHeader ParsePlyHeader(std::string_view bytes, const PlyContext& context);

}  // namespace lacquer
