#include "cmd/materialgan/generator_path.h"

#include <filesystem>

#include "pbrt/core/error.h"
#include "pbrt/core/parallel.h"

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

int UseThreads(const materialgan::MaterialPrior& prior, int asked) {
    constexpr int kSmall = 128;
    const bool isSmall = prior.Config().resolution <= kSmall;
    const int threads = asked > 0 ? asked : isSmall ? 1 : AllowedThreads();
    materialgan::SetTorchThreads(threads);
    return threads;
}

}  // namespace lacquer::cmd
