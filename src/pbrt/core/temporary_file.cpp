#include "pbrt/core/temporary_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>

#include "pbrt/core/error.h"

namespace lacquer {

namespace fs = std::filesystem;

TemporaryFile::TemporaryFile(std::string path) : path_(std::move(path)) {
    static std::atomic<unsigned> counter{0};
    const std::string name = fmt::format(".lacquer-{}-{}.tmp", getpid(), counter++);
    name_ = (fs::path(path_).parent_path() / name).string();
}

TemporaryFile::~TemporaryFile() {
    std::error_code ignored;
    if (!name_.empty()) fs::remove(name_, ignored);
}

void TemporaryFile::Rename() {
    std::error_code error;
    fs::rename(name_, path_, error);
    if (error) throw FileError(path_, fmt::format("cannot be replaced: {}", error.message()));
    name_.clear();
}

}  // namespace lacquer
