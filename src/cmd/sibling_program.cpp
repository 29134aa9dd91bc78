#include "cmd/sibling_program.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <filesystem>
#include <system_error>

#include "pbrt/core/error.h"

namespace lacquer::cmd {

void GoOnAsMaterialgan(const std::vector<std::string>& words) {
    const std::string name = "lacquer-materialgan";
    const std::string program = std::filesystem::read_symlink("/proc/self/exe").parent_path() / name;
    std::vector<char*> arguments{const_cast<char*>(name.c_str())};
    for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    execv(program.c_str(), arguments.data());
    const int error = errno;
    if (error == ENOENT)
        throw CLI::ValidationError(fmt::format(
            "this build has no {}, which fits with a generator need: install libtorch-dev (0.33 GB) "
            "and build with -DLACQUER_MATERIALGAN=ON (cmake --preset torch)",
            name));
    throw FileError(program, fmt::format("cannot be run: {}", std::generic_category().message(error)));
}

}  // namespace lacquer::cmd
