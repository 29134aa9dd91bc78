#include "cmd/scenes/scene_arguments.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <vector>

#include "materialx/document.h"
#include "pbrt/scene/source.h"

namespace lacquer::cmd {
namespace {

constexpr const char* kStandardInput = "<stdin>";

std::string ReadStandardInput() {
    constexpr size_t kPart = 1 << 18;
    if (isatty(STDIN_FILENO))
        throw CLI::ValidationError(
            "no scene: name a scene file, or pipe a scene to standard input, which is a terminal now");
    std::string text;
    std::vector<char> part(kPart);
    while (true) {
        const ssize_t count = read(STDIN_FILENO, part.data(), part.size());
        if (count < 0 && errno == EINTR) continue;
        if (count < 0)
            throw FileError(kStandardInput, fmt::format("cannot be read: {}", std::strerror(errno)));
        if (count == 0) break;
        text.append(part.data(), size_t(count));
        if (text.size() > kMaxSourceBytes)
            throw FileError(
                kStandardInput,
                fmt::format("the scene is larger than {} bytes, the most that is read", kMaxSourceBytes));
    }
    const bool isBlank = text.find_first_not_of(" \t\r\n") == std::string::npos;
    if (isBlank)
        throw SceneErrors(
            {{Diagnostic::Severity::Error, {kStandardInput, 0, 0}, "standard input holds no scene"}});
    return text;
}

}  // namespace

std::vector<SceneInput> ReadSceneArguments(const std::vector<std::string>& paths) {
    if (paths.empty()) return {{kStandardInput, ReadStandardInput()}};
    if (std::count(paths.begin(), paths.end(), "-") > 1)
        throw CLI::ValidationError("\"-\" is given twice, but standard input can be read only once");
    std::vector<SceneInput> inputs;
    for (const std::string& path : paths)
        if (path == "-")
            inputs.push_back({kStandardInput, ReadStandardInput()});
        else
            inputs.push_back({path, std::nullopt});
    return inputs;
}

std::vector<SceneInput> ReadMaterialArguments(const std::vector<std::string>& paths, Observer* observer) {
    std::vector<SceneInput> inputs = ReadSceneArguments(paths);
    for (SceneInput& input : inputs) {
        if (input.text || !materialx::IsDocumentName(input.name)) continue;
        const materialx::MaterialText document = materialx::ReadDocument(input.name);
        if (observer)
            for (const Diagnostic& warning : document.warnings) observer->Warn(warning.ToString());
        const bool isFirst = &input == inputs.data();
        input.text = (isFirst ? "WorldBegin\n" : "") + document.text;
    }
    return inputs;
}

bool IsSceneName(const std::string& path) { return path.ends_with(".pbrt") || path.ends_with(".pbrt.gz"); }

std::string FirstSceneName(const std::vector<std::string>& paths) {
    return paths.empty() || paths[0] == "-" ? kStandardInput : paths[0];
}

}  // namespace lacquer::cmd
