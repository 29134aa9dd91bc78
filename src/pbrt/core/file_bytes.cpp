#include "pbrt/core/file_bytes.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace lacquer {

namespace {

class Descriptor {
  public:
    Descriptor(const std::string& path, int flags) : fd_(open(path.c_str(), O_RDONLY | O_CLOEXEC | flags)) {}
    ~Descriptor() {
        if (fd_ >= 0) close(fd_);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    int Get() const { return fd_; }

  private:
    int fd_;
};

/// A file that is being read: its name in messages, and what is allowed.
struct Reading {
    const std::string& path;
    const FileLoc& loc;
    const ReadLimits& limits;

    [[noreturn]] void Fail(const std::string& problem) const { throw FileError(path, problem, loc); }
    [[noreturn]] void FailTooLarge(const char* state, size_t maxBytes) const {
        Fail(fmt::format("the file is larger than {} bytes{}, the most that is read{}", maxBytes, state,
                         limits.advice));
    }
};

void Resize(FileBytes* bytes, size_t size, const Reading& reading) {
    char* grown = static_cast<char*>(std::realloc(bytes->data.get(), std::max<size_t>(size, 1)));
    if (!grown) reading.Fail(fmt::format("no memory for its {} bytes", size));
    (void)bytes->data.release();
    bytes->data.reset(grown);
    bytes->size = size;
}

// The bytes that the open file claims to have, 0 for pipes and devices.
size_t CheckKind(const Descriptor& file, const Reading& reading) {
    if (file.Get() < 0) reading.Fail(fmt::format("cannot be opened: {}", std::strerror(errno)));
    struct stat status {};
    const bool isKnown = fstat(file.Get(), &status) == 0;
    if (isKnown && S_ISDIR(status.st_mode)) reading.Fail("is a folder, not a regular file");
    const bool isRegular = isKnown && S_ISREG(status.st_mode);
    if (!isRegular && reading.limits.regularOnly) reading.Fail("is not a regular file");
    return isRegular ? size_t(status.st_size) : 0;
}

FileBytes ReadRaw(const Reading& reading) {
    // A named pipe without a writer holds up whoever opens it, unless it is told not to wait.
    const Descriptor file(reading.path, reading.limits.regularOnly ? O_NONBLOCK : 0);
    const size_t maxBytes = reading.limits.maxBytes, claimed = CheckKind(file, reading);
    if (claimed > maxBytes) reading.FailTooLarge("", maxBytes);

    // One byte more than the file has, so that its end is seen without another growth.
    FileBytes bytes;
    Resize(&bytes, claimed + 1, reading);
    size_t done = 0;
    while (true) {
        const ssize_t count = read(file.Get(), bytes.data.get() + done, bytes.size - done);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) reading.Fail(fmt::format("cannot be read: {}", std::strerror(errno)));
        if (count == 0) break;
        done += size_t(count);
        if (done > maxBytes) reading.FailTooLarge("", maxBytes);
        if (done == bytes.size)
            Resize(&bytes, std::min(maxBytes + 1, std::max<size_t>(2 * done, 65536)), reading);
    }
    bytes.size = done;
    return bytes;
}

// zlib's stream, freed whatever happens.
struct Inflater {
    Inflater() { ok = inflateInit2(&stream, 15 + 16) == Z_OK; }
    ~Inflater() { inflateEnd(&stream); }
    Inflater(const Inflater&) = delete;
    Inflater& operator=(const Inflater&) = delete;
    z_stream stream{};
    bool ok;
};

// Meshes and scenes shrink by a factor of 3 to 50; what unzips to far more is damaged or made to fill the
// memory.
size_t MaxUnzippedBytes(size_t zippedBytes, size_t maxBytes) {
    constexpr size_t kAlways = size_t(256) << 20, kMaxRatio = 200;
    return std::min(maxBytes, std::max(kAlways, kMaxRatio * zippedBytes));
}

FileBytes Unzip(const FileBytes& zipped, const Reading& reading) {
    const size_t maxBytes = MaxUnzippedBytes(zipped.size, reading.limits.maxBytes);
    Inflater inflater;
    z_stream& stream = inflater.stream;
    FileBytes bytes;
    bytes.wasZipped = true;
    size_t done = 0, consumed = 0;
    int result = inflater.ok ? Z_OK : Z_MEM_ERROR;
    while (result == Z_OK || (result == Z_STREAM_END && consumed < zipped.size)) {
        // One gzip file may be several members in a row.
        if (result == Z_STREAM_END && inflateReset(&stream) != Z_OK) break;
        if (done == bytes.size)
            Resize(&bytes, std::min(maxBytes + 1, std::max<size_t>({2 * done, 4 * zipped.size, 65536})),
                   reading);
        constexpr size_t kStep = size_t(1) << 30;
        const size_t in = std::min(zipped.size - consumed, kStep), out = std::min(bytes.size - done, kStep);
        stream.next_in = reinterpret_cast<Bytef*>(zipped.data.get() + consumed);
        stream.avail_in = uInt(in);
        stream.next_out = reinterpret_cast<Bytef*>(bytes.data.get() + done);
        stream.avail_out = uInt(out);
        result = inflate(&stream, Z_NO_FLUSH);
        consumed += in - stream.avail_in;
        done += out - stream.avail_out;
        if (done > maxBytes) reading.FailTooLarge(" when unzipped", maxBytes);
    }
    if (result != Z_STREAM_END)
        throw SceneError(reading.loc,
                         fmt::format("{}: the gzip data is damaged or cut off after {} unzipped bytes",
                                     reading.path, done));
    Resize(&bytes, done, reading);
    return bytes;
}

}  // namespace

FileBytes ReadFileBytes(const std::string& path, const FileLoc& loc, const ReadLimits& limits) {
    const Reading reading{path, loc, limits};
    FileBytes bytes = ReadRaw(reading);
    return bytes.View().starts_with("\x1f\x8b") ? Unzip(bytes, reading) : std::move(bytes);
}

std::string ReadFirstBytes(const std::string& path, const FileLoc& loc, size_t count) {
    const ReadLimits limits{.maxBytes = count};
    const Reading reading{path, loc, limits};
    const Descriptor file(path, O_NONBLOCK);
    std::string bytes(std::min(CheckKind(file, reading), count), '\0');
    size_t done = 0;
    while (done < bytes.size()) {
        const ssize_t part = read(file.Get(), bytes.data() + done, bytes.size() - done);
        if (part < 0 && errno == EINTR) continue;
        if (part < 0) reading.Fail(fmt::format("cannot be read: {}", std::strerror(errno)));
        if (part == 0) break;
        done += size_t(part);
    }
    bytes.resize(done);
    return bytes;
}

}  // namespace lacquer
