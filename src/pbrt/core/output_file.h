// How files are written: they come into being whole, and what was there before stays until then.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace lacquer {

/// A new file, which nobody sees and nothing is left of unless it gets its name. Until then it has none, or,
/// on file systems that know no files without a name, an unforeseeable one in the same folder, which only
/// the end of the process by force leaves behind. A link is followed: the file that it leads to is replaced.
/// What is there and is no regular file (a device, a pipe) takes the bytes at once.
class OutputFile {
  public:
    /// Errors of all functions: FileError about `path`.
    explicit OutputFile(std::string path);
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;
    ~OutputFile();
    /// Fails now rather than in the middle if there is no room.
    void Reserve(uint64_t bytes);
    void Write(std::span<const unsigned char> bytes);
    void Write(std::string_view text);
    /// Not for devices. @param begin  in the file [bytes]
    void WriteAt(uint64_t begin, std::span<const unsigned char> bytes);
    /// Waits until the bytes would survive a loss of power.
    void Sync();
    /// Puts the file in the place of `path`.
    void Finish();

  private:
    void OpenTemporary();
    void Close();
    [[noreturn]] void Fail(int error) const;

    std::string path_;       ///< as it was given
    std::string target_;     ///< where links lead to
    std::string name_;       ///< of the temporary file; empty: it has none
    bool isDirect_ = false;  ///< a device or a pipe
    int file_ = -1;
};

}  // namespace lacquer
