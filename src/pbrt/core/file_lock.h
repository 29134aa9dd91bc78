// One process at a time for a file.
#pragma once

#include <string>

namespace lacquer {

/// Holds a lock beside a file, "NAME.lock", while it lives. What a killed process leaves of it does no harm.
class FileLock {
  public:
    /// Errors: FileError if another process holds it. File systems without locks give it to everyone.
    explicit FileLock(const std::string& path);
    FileLock(const FileLock&) = delete;
    FileLock& operator=(const FileLock&) = delete;
    ~FileLock();

  private:
    std::string name_;
    int file_;
};

}  // namespace lacquer
