// What the fuzz targets share: their table, the files that they hand to readers, and which errors are right.
#pragma once

#include <string>
#include <string_view>

#include "pbrt/core/registry.h"

namespace lacquer::fuzz {

/// Hands any bytes to a reader of what users write. It may refuse them with the errors of users
/// (core/error.h); any other exception, a report of a sanitizer, 10 s, or 2 GB are findings.
struct FuzzTargetKind {
    static constexpr const char* kKind = "fuzz target";
    using Factory = void (*)(std::string_view bytes);
};
using FuzzTarget = FuzzTargetKind::Factory;

/// True if the target has read the bytes, false if it refused them with an error of users. Throws what else
/// it throws.
bool Accepts(FuzzTarget target, std::string_view bytes);

/// A file in memory, for readers that want a path. Its name has no extension.
class InputFile {
  public:
    explicit InputFile(std::string_view bytes);
    ~InputFile();
    InputFile(const InputFile&) = delete;
    InputFile& operator=(const InputFile&) = delete;
    const std::string& Path() const { return path_; }

  private:
    int file_;
    std::string path_;
};

/// A folder of its own among the temporary ones, for readers that look for files by their names or write
/// beside them.
class InputFolder {
  public:
    InputFolder();
    ~InputFolder();
    InputFolder(const InputFolder&) = delete;
    InputFolder& operator=(const InputFolder&) = delete;
    const std::string& Path() const { return path_; }
    /// Writes a file there. @return  its path
    std::string Write(const std::string& name, std::string_view bytes) const;

  private:
    std::string path_;
};

/// `file` with patches: each eight bytes are a place, modulo the length, and four bytes for there. For files
/// whose smallest are too large to be mutated as a whole.
std::string Patched(std::string_view file, std::string_view patches);

/// What a reader must keep, whatever it reads: a std::logic_error, which is a finding.
void Require(bool claim, const char* what);

}  // namespace lacquer::fuzz
