#include "pbrt/core/file_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "pbrt/core/error.h"

namespace lacquer {

namespace {

/// True while the name still stands for the open file: its last owner removes it.
bool IsCurrent(int file, const std::string& name) {
    struct stat open {
    }, named{};
    return fstat(file, &open) == 0 && stat(name.c_str(), &named) == 0 && open.st_ino == named.st_ino &&
           open.st_dev == named.st_dev;
}

}  // namespace

FileLock::FileLock(const std::string& path) : name_(path + ".lock") {
    while (true) {
        file_ = open(name_.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0666);
        if (file_ < 0) throw FileError(name_, fmt::format("cannot be made: {}", std::strerror(errno)));
        if (flock(file_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
            close(file_);
            throw FileError(path, "is in use by another process");
        }
        if (IsCurrent(file_, name_)) return;
        close(file_);
    }
}

FileLock::~FileLock() {
    unlink(name_.c_str());
    close(file_);
}

}  // namespace lacquer
