#include "cmd/command_support.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <fstream>

#include "pbrt/core/error.h"

namespace lacquer {

void CheckName(const char* option, const std::string& name, const std::vector<std::string>& known) {
    if (std::find(known.begin(), known.end(), name) != known.end()) return;
    throw CLI::ValidationError(fmt::format("{} \"{}\": unknown{} (known: {})", option, Excerpt(name),
                                           DidYouMean(name, known), fmt::join(known, ", ")));
}

void WriteText(const std::string& path, const std::string& text) {
    std::error_code error;
    const bool isDevice =
        std::filesystem::exists(path, error) && !std::filesystem::is_regular_file(path, error);
    const std::string temporary = isDevice ? path : path + ".part";
    {
        std::ofstream out(temporary, std::ios::binary);
        out << text;
        out.close();
        if (!out) {
            if (!isDevice) std::filesystem::remove(temporary, error);
            throw FileError(path, "cannot be written");
        }
    }
    if (isDevice) return;
    std::filesystem::rename(temporary, path, error);
    if (error) throw FileError(path, error.message());
}

}  // namespace lacquer
