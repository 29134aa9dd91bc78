#include "cmd/command_support.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <sstream>

#include "pbrt/base/film.h"
#include "pbrt/core/error.h"
#include "pbrt/core/output_file.h"
#include "pbrt/image/image.h"

namespace lacquer::cmd {

namespace fs = std::filesystem;

void BadOption(const std::string& option, const std::string& value, const std::string& expected) {
    throw CLI::ValidationError(fmt::format("--{} \"{}\": expected {}", option, Excerpt(value), expected));
}

std::string NormalizedName(const std::string& name) {
    std::string result;
    for (const char c : name)
        if (c != '-' && c != '_') result += char(std::tolower((unsigned char)c));
    return result;
}

Int2 ParseResolution(const std::string& option, const std::string& text) {
    std::istringstream in(text);
    Int2 r(0);
    char separator = 0, rest = 0;
    if (!(in >> r.x >> separator >> r.y) || !std::strchr("xX,", separator) || in >> rest)
        BadOption(option, text, "WIDTHxHEIGHT");
    if (r.x < 1 || r.y < 1 || r.x > kMaxFilmSide || r.y > kMaxFilmSide)
        BadOption(option, text, fmt::format("a width and a height between 1 and {}", kMaxFilmSide));
    return r;
}

void CheckOutputFolder(const std::string& path) {
    if (path.empty()) throw CLI::ValidationError("--out \"\": expected the name of a folder");
    std::error_code error;
    if (fs::exists(path, error)) {
        if (!fs::is_directory(path, error)) throw FileError(path, "is no folder");
        if (access(path.c_str(), W_OK) != 0)
            throw FileError(path, fmt::format("nothing can be written into it: {}", std::strerror(errno)));
        return;
    }
    fs::path folder = fs::absolute(path).lexically_normal();
    if (!folder.has_filename()) folder = folder.parent_path();  // written with a slash at its end
    const fs::path parent = folder.parent_path();
    if (!fs::is_directory(parent, error))
        throw FileError(path, "this folder cannot be made: no such file or directory above it");
    if (access(parent.c_str(), W_OK) != 0)
        throw FileError(path, fmt::format("this folder cannot be made: {}", std::strerror(errno)));
}

void MakeOutputFolder(const std::string& path) {
    std::error_code error;
    fs::create_directory(path, error);
    if (error) throw FileError(path, fmt::format("this folder cannot be made: {}", error.message()));
}

void CheckOutputFile(const std::string& path) {
    const fs::path folder = fs::path(path).parent_path();
    std::error_code ignored;
    if (!folder.empty() && !fs::is_directory(folder, ignored))
        throw FileError(path, "its folder does not exist");
    if (fs::is_directory(path, ignored)) throw FileError(path, "is a folder");
    // Files are replaced, by a new one in their folder; devices are not. To begin one tells most.
    if (fs::exists(path, ignored) && !fs::is_regular_file(path, ignored)) return;
    const OutputFile probe(path);
}

void CheckOutputsApart(const std::vector<NamedOutput>& outputs, const std::vector<std::string>& inputs) {
    const auto place = [](const std::string& path) {
        std::error_code error;
        if (path.empty() || (fs::exists(path, error) && !fs::is_regular_file(path, error))) return fs::path();
        return fs::weakly_canonical(fs::absolute(path, error), error);
    };
    const auto areSame = [](const fs::path& a, const fs::path& b) {
        std::error_code error;
        return a == b || fs::equivalent(a, b, error);  // or two names of one file
    };
    std::vector<fs::path> read, written;
    for (const std::string& input : inputs)
        if (fs::path p = place(input); !p.empty()) read.push_back(std::move(p));
    for (const NamedOutput& output : outputs) {
        written.push_back(place(output.path));
        if (written.back().empty()) continue;
        for (const fs::path& input : read)
            if (areSame(written.back(), input))
                throw FileError(output.path,
                                fmt::format("is read for this image; {} would replace it", output.option));
        for (size_t i = 0; i + 1 < written.size(); ++i)
            if (!written[i].empty() && areSame(written[i], written.back()))
                throw FileError(output.path, fmt::format("{} and {} name the same file", outputs[i].option,
                                                         output.option));
    }
}

void CheckImageOutput(const std::string& path) {
    if (!CanWriteImage(path))
        throw FileError(path, fmt::format("no image format for this name; known are {}",
                                          fmt::join(WritableExtensions(), ", ")));
    CheckOutputFile(path);
}

TextureMemory TextureMemoryOf(int megabytes, const std::string& folder) {
    namespace fs = std::filesystem;
    const auto variable = [](const char* name) {
        const char* value = std::getenv(name);
        return std::string(value ? value : "");
    };
    TextureMemory memory;
    memory.bytes = size_t(megabytes) << 20;
    std::error_code error;
    memory.temporaryFolder = fs::temp_directory_path(error).string();
    if (error) memory.temporaryFolder = "/tmp";
    memory.cacheFolder = folder == "none" ? "" : folder;
    if (!folder.empty()) return memory;
    // [XDG Base Directory Specification]; relative paths there are to be ignored.
    fs::path base = variable("XDG_CACHE_HOME");
    if (!base.is_absolute()) base = fs::path(variable("HOME")) / ".cache";
    if (base.is_absolute()) memory.cacheFolder = (base / "lacquer" / "textures").string();
    return memory;
}

TextureMemory DefaultTextureMemory() { return TextureMemoryOf(kDefaultTextureMegabytes, ""); }

std::string JsonText(const nlohmann::ordered_json& value, int indent) {
    return value.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

void WriteText(const std::string& path, const std::string& text) {
    OutputFile file(path);
    file.Write(text);
    file.Finish();
}

}  // namespace lacquer::cmd
