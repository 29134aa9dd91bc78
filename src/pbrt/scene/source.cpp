#include "pbrt/scene/source.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>

#include "pbrt/core/error.h"

namespace lacquer {

namespace {

struct CloseFile {
    void operator()(std::FILE* file) const { std::fclose(file); }
    void operator()(gzFile_s* file) const { gzclose(file); }
};

// Appends what `read(buffer, size)` gives, 0 at the end and -1 on errors, until the end or just past the
// limit.
template <class Read>
bool ReadAll(const Read& read, size_t limit, std::string* text) {
    size_t size = 0;
    while (size <= limit) {
        const size_t wanted = std::min({std::max(size, size_t(1) << 16), size_t(1) << 26, limit + 1 - size});
        text->resize(size + wanted);
        const long got = read(text->data() + size, wanted);
        if (got < 0) return false;
        if (got == 0) break;
        size += size_t(got);
    }
    text->resize(size);
    return true;
}

std::string ReadPlain(const std::string& path, size_t limit) {
    const std::unique_ptr<std::FILE, CloseFile> file(std::fopen(path.c_str(), "rb"));
    if (!file) throw FileError(path, std::strerror(errno));
    // One block more than the file holds, so that its end is seen without another growth.
    std::string text;
    std::error_code ignored;
    const auto size = std::filesystem::file_size(path, ignored);
    if (!ignored && size <= limit) text.reserve(size_t(size) + (size_t(1) << 16));
    const auto read = [&](char* buffer, size_t bytes) {
        const size_t got = std::fread(buffer, 1, bytes, file.get());
        return got == 0 && std::ferror(file.get()) ? -1L : long(got);
    };
    if (!ReadAll(read, limit, &text)) throw FileError(path, std::strerror(errno));
    return text;
}

std::string ReadGzip(const std::string& path, size_t limit) {
    const std::unique_ptr<gzFile_s, CloseFile> file(gzopen(path.c_str(), "rb"));
    if (!file) throw FileError(path, std::strerror(errno));
    gzbuffer(file.get(), 1u << 17);
    std::string text;
    const auto read = [&](char* buffer, size_t bytes) {
        return long(gzread(file.get(), buffer, unsigned(bytes)));
    };
    if (!ReadAll(read, limit, &text)) throw FileError(path, "damaged gzip data");
    if (gzdirect(file.get())) throw FileError(path, "the name ends in .gz, but this is no gzip data");
    if (text.size() <= limit && gzeof(file.get()) == 0) throw FileError(path, "damaged gzip data");
    int state = Z_OK;
    gzerror(file.get(), &state);
    if (state != Z_OK) throw FileError(path, "the gzip data ends too early");
    return text;
}

}  // namespace

void RejectByteOrderMark(const Source& source) {
    const FileLoc start{source.name, 1, 1};
    if (source.text.starts_with("\xFE\xFF") || source.text.starts_with("\xFF\xFE"))
        throw SceneError(start, "the file is in UTF-16; save it as UTF-8");
    if (source.text.starts_with("\xEF\xBB\xBF"))
        throw SceneError(start, "the file begins with a UTF-8 byte-order mark; save it without one");
}

Source ReadSource(const std::string& path, size_t limit) {
    std::error_code ignored;
    Source source;
    source.name = path;
    if (std::filesystem::is_directory(path, ignored)) throw FileError(path, "is a folder, not a scene file");
    source.text = path.ends_with(".gz") ? ReadGzip(path, limit) : ReadPlain(path, limit);
    if (source.text.size() > limit)
        throw FileError(path,
                        fmt::format("more than {} bytes of text; move large meshes to PLY files", limit));
    source.key = std::filesystem::weakly_canonical(path, ignored).string();
    if (source.key.empty()) source.key = path;
    RejectByteOrderMark(source);
    return source;
}

}  // namespace lacquer
