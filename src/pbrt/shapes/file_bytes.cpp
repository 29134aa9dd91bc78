#include "pbrt/shapes/file_bytes.h"

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
    explicit Descriptor(const std::string& path)
        : fd_(open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {}
    ~Descriptor() {
        if (fd_ >= 0) close(fd_);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    int Get() const { return fd_; }

  private:
    int fd_;
};

void Resize(FileBytes* bytes, size_t size, const std::string& path, const FileLoc& loc) {
    char* grown = static_cast<char*>(std::realloc(bytes->data.get(), std::max<size_t>(size, 1)));
    if (!grown) throw FileError(path, fmt::format("no memory for its {} bytes", size), loc);
    (void)bytes->data.release();
    bytes->data.reset(grown);
    bytes->size = size;
}

[[noreturn]] void FailTooLarge(const std::string& path, size_t maxBytes, const FileLoc& loc) {
    throw FileError(path, fmt::format("the file is larger than {} bytes, the most that is read", maxBytes),
                    loc);
}

FileBytes ReadRaw(const std::string& path, const FileLoc& loc, size_t maxBytes) {
    const Descriptor file(path);
    if (file.Get() < 0) throw FileError(path, fmt::format("cannot be opened: {}", std::strerror(errno)), loc);
    struct stat status {};
    if (fstat(file.Get(), &status) != 0 || !S_ISREG(status.st_mode))
        throw FileError(path, "is not a regular file", loc);
    if (size_t(status.st_size) > maxBytes) FailTooLarge(path, maxBytes, loc);

    FileBytes bytes;
    Resize(&bytes, size_t(status.st_size), path, loc);
    size_t done = 0;
    while (done < bytes.size) {
        const ssize_t count = read(file.Get(), bytes.data.get() + done, bytes.size - done);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) throw FileError(path, fmt::format("cannot be read: {}", std::strerror(errno)), loc);
        if (count == 0) break;
        done += size_t(count);
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

// Meshes shrink by a factor of 3 to 50; what unzips to far more is damaged or made to fill the memory.
size_t MaxUnzippedBytes(size_t zippedBytes, size_t maxBytes) {
    constexpr size_t kAlways = size_t(256) << 20, kMaxRatio = 200;
    return std::min(maxBytes, std::max(kAlways, kMaxRatio * zippedBytes));
}

FileBytes Unzip(const FileBytes& zipped, const std::string& path, const FileLoc& loc, size_t maxBytes) {
    maxBytes = MaxUnzippedBytes(zipped.size, maxBytes);
    Inflater inflater;
    z_stream& stream = inflater.stream;
    FileBytes bytes;
    size_t done = 0, consumed = 0;
    int result = inflater.ok ? Z_OK : Z_MEM_ERROR;
    while (result == Z_OK || (result == Z_STREAM_END && consumed < zipped.size)) {
        // One gzip file may be several members in a row.
        if (result == Z_STREAM_END && inflateReset(&stream) != Z_OK) break;
        if (done == bytes.size) {
            if (done >= maxBytes) FailTooLarge(path, maxBytes, loc);
            Resize(&bytes, std::min(maxBytes, std::max<size_t>({2 * done, 4 * zipped.size, 65536})), path,
                   loc);
        }
        constexpr size_t kStep = size_t(1) << 30;
        const size_t in = std::min(zipped.size - consumed, kStep), out = std::min(bytes.size - done, kStep);
        stream.next_in = reinterpret_cast<Bytef*>(zipped.data.get() + consumed);
        stream.avail_in = uInt(in);
        stream.next_out = reinterpret_cast<Bytef*>(bytes.data.get() + done);
        stream.avail_out = uInt(out);
        result = inflate(&stream, Z_NO_FLUSH);
        consumed += in - stream.avail_in;
        done += out - stream.avail_out;
    }
    if (result != Z_STREAM_END)
        throw SceneError(
            loc, fmt::format("{}: the gzip data is damaged or cut off after {} unzipped bytes", path, done));
    Resize(&bytes, done, path, loc);
    return bytes;
}

}  // namespace

FileBytes ReadFileBytes(const std::string& path, const FileLoc& loc, size_t maxBytes) {
    FileBytes bytes = ReadRaw(path, loc, maxBytes);
    const bool zipped = bytes.size >= 2 && bytes.data.get()[0] == '\x1f' && bytes.data.get()[1] == '\x8b';
    return zipped ? Unzip(bytes, path, loc, maxBytes) : std::move(bytes);
}

}  // namespace lacquer
