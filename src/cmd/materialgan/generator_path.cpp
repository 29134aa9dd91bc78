#include "cmd/materialgan/generator_path.h"

#include <filesystem>

#include "pbrt/core/error.h"

namespace lacquer::cmd {

namespace fs = std::filesystem;

std::string GeneratorPath(const std::string& name) {
    if (name != kShippedGenerator) return name;
    const std::string file = "materialgan/materials-64.safetensors";
    const fs::path programs = fs::read_symlink("/proc/self/exe").parent_path();
    const fs::path installed = programs.parent_path() / LACQUER_SHARE_FOLDER / file,
                   source = fs::path(LACQUER_DATA_FOLDER) / file;
    std::error_code ignored;
    for (const fs::path& path : {installed, source})
        if (fs::exists(path, ignored)) return path.lexically_normal();
    throw FileError(installed.lexically_normal(), "is not there: the generator that comes with Lacquer");
}

}  // namespace lacquer::cmd
