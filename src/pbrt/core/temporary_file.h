// Files are written under a temporary name and renamed: what was there before stays until the new one is
// whole.
#pragma once

#include <string>

namespace lacquer {

/// A name for a new file, which vanishes unless it gets its final name.
class TemporaryFile {
  public:
    /// Beside `path`, so that it can be renamed. Makes no file.
    explicit TemporaryFile(std::string path);
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;
    ~TemporaryFile();
    const std::string& Name() const { return name_; }
    /// Puts the file in the place of `path`. Errors: FileError.
    void Rename();

  private:
    std::string path_, name_;
};

}  // namespace lacquer
