#include "fuzz/fuzz_target.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <system_error>

#include "pbrt/core/error.h"

namespace lacquer::fuzz {

bool Accepts(FuzzTarget target, std::string_view bytes) {
    try {
        target(bytes);
        return true;
    } catch (const SceneErrors&) {
    } catch (const SceneError&) {
    } catch (const FileError&) {
    }
    return false;
}

InputFile::InputFile(std::string_view bytes) : file_(memfd_create("fuzz-input", MFD_CLOEXEC)) {
    if (file_ < 0) throw std::system_error(errno, std::generic_category(), "memfd_create");
    path_ = fmt::format("/proc/self/fd/{}", file_);
    while (!bytes.empty()) {
        const ssize_t count = write(file_, bytes.data(), bytes.size());
        if (count < 0) throw std::system_error(errno, std::generic_category(), "write");
        bytes.remove_prefix(size_t(count));
    }
}

InputFile::~InputFile() { close(file_); }

InputFolder::InputFolder()
    : path_((std::filesystem::temp_directory_path() / "lacquer-fuzz-XXXXXX").string()) {
    if (!mkdtemp(path_.data())) throw std::system_error(errno, std::generic_category(), path_);
}

InputFolder::~InputFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
}

std::string InputFolder::Write(const std::string& name, std::string_view bytes) const {
    std::string path = path_ + "/" + name;
    std::ofstream(path, std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
    return path;
}

std::string Patched(std::string_view file, std::string_view patches) {
    std::string patched(file);
    uint32_t at = 0;
    for (; patches.size() >= 2 * sizeof at; patches.remove_prefix(2 * sizeof at)) {
        std::memcpy(&at, patches.data(), sizeof at);
        at %= uint32_t(file.size());
        std::memcpy(&patched[at], patches.data() + sizeof at, std::min(sizeof at, file.size() - at));
    }
    return patched;
}

void Require(bool claim, const char* what) {
    if (!claim) throw std::logic_error(what);
}

}  // namespace lacquer::fuzz
