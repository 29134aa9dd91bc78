#include "pbrt/core/output_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>

#include "pbrt/core/error.h"

namespace lacquer {
namespace {

namespace fs = std::filesystem;

constexpr mode_t kMode = 0666;  // less the umask

/// The file that a chain of links leads to, which may not exist; `path` itself if it is no link.
std::string TargetOf(std::string path) {
    constexpr int kMaxLinks = 40;  // as the kernel's
    std::error_code error;
    for (int i = 0; i < kMaxLinks && fs::is_symlink(path, error); ++i) {
        const fs::path link = fs::read_symlink(path, error);
        if (error) break;
        path = (fs::path(path).parent_path() / link).string();
    }
    return path;
}

std::string FolderOf(const std::string& path) {
    const std::string folder = fs::path(path).parent_path().string();
    return folder.empty() ? "." : folder;
}

/// A name beside `path` that nobody can foresee, and so prepare.
std::string TemporaryName(const std::string& path) {
    uint64_t number = 0;
    if (getrandom(&number, sizeof number, 0) != ssize_t(sizeof number)) number = uint64_t(getpid());
    return fmt::format("{}/.lacquer-{:016x}.tmp", FolderOf(path), number);
}

/// The name by which the system knows an open file.
std::string NameOfOpen(int file) { return fmt::format("/proc/self/fd/{}", file); }

/// Calls `attempt` with new names until it returns another error than that there is such a file.
/// @return  the name; empty if it failed otherwise (errno)
template <class Attempt>
std::string FirstFreeName(const std::string& path, Attempt&& attempt) {
    constexpr int kMaxAttempts = 100;
    for (int i = 0; i < kMaxAttempts; ++i) {
        std::string name = TemporaryName(path);
        if (attempt(name)) return name;
        if (errno != EEXIST) break;
    }
    return {};
}

}  // namespace

OutputFile::OutputFile(std::string path) : path_(std::move(path)), target_(TargetOf(path_)) {
    struct stat status;
    const bool exists = stat(target_.c_str(), &status) == 0;
    if (!exists && errno == ELOOP) Fail(errno);
    isDirect_ = exists && !S_ISREG(status.st_mode);
    if (isDirect_)
        file_ = open(target_.c_str(), O_WRONLY | O_CLOEXEC);
    else
        OpenTemporary();
    if (file_ < 0) Fail(errno);
}

OutputFile::~OutputFile() { Close(); }

/// Leaves `file_` at -1, and errno, if it cannot.
void OutputFile::OpenTemporary() {
    file_ = open(FolderOf(target_).c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, kMode);
    if (file_ >= 0) {
        // It gets its name through /proc, which not every container has.
        if (access(NameOfOpen(file_).c_str(), F_OK) == 0) return;
        Close();
    } else if (errno != EOPNOTSUPP && errno != EISDIR && errno != EINVAL) {
        return;
    }
    name_ = FirstFreeName(target_, [&](const std::string& name) {
        file_ = open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, kMode);
        return file_ >= 0;
    });
}

void OutputFile::Close() {
    const int file = std::exchange(file_, -1);
    if (file >= 0) close(file);
    if (!name_.empty()) unlink(name_.c_str());
    name_.clear();
}

void OutputFile::Reserve(uint64_t bytes) {
    if (isDirect_) return;
    const int error = posix_fallocate(file_, 0, off_t(bytes));
    // Not every file system can; what matters is whether there is room.
    if (error == ENOSPC || error == EDQUOT || error == EFBIG) Fail(error);
}

void OutputFile::Write(std::span<const unsigned char> bytes) {
    while (!bytes.empty()) {
        const ssize_t count = write(file_, bytes.data(), bytes.size());
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) Fail(count == 0 ? ENOSPC : errno);
        bytes = bytes.subspan(size_t(count));
    }
}

void OutputFile::Write(std::string_view text) {
    Write(std::span(reinterpret_cast<const unsigned char*>(text.data()), text.size()));
}

void OutputFile::WriteAt(uint64_t begin, std::span<const unsigned char> bytes) {
    while (!bytes.empty()) {
        const ssize_t count = pwrite(file_, bytes.data(), bytes.size(), off_t(begin));
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) Fail(count == 0 ? ENOSPC : errno);
        begin += uint64_t(count);
        bytes = bytes.subspan(size_t(count));
    }
}

void OutputFile::Sync() {
    if (!isDirect_ && fsync(file_) != 0) Fail(errno);
}

void OutputFile::Finish() {
    if (!isDirect_ && name_.empty()) {
        const std::string source = NameOfOpen(file_);
        const auto isLinked = [&](const std::string& name) {
            return linkat(AT_FDCWD, source.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0;
        };
        if (!isLinked(target_)) {
            // There is such a file. Nothing can be put in its place without a name of its own.
            if (errno != EEXIST) Fail(errno);
            name_ = FirstFreeName(target_, isLinked);
            if (name_.empty()) Fail(errno);
        }
    }
    // Some file systems tell only now what was not written.
    const int file = std::exchange(file_, -1);
    if (close(file) != 0) {
        const int error = errno;
        Close();
        Fail(error);
    }
    if (!name_.empty() && rename(name_.c_str(), target_.c_str()) != 0) Fail(errno);
    name_.clear();
}

void OutputFile::Fail(int error) const {
    throw FileError(path_, fmt::format("cannot be written: {}", std::strerror(error)));
}

}  // namespace lacquer
