#include "cmd/earlier_files.h"

#include <filesystem>
#include <fstream>

namespace lacquer::cmd {

namespace {

namespace fs = std::filesystem;

bool IsPlainName(const fs::path& name) { return !name.empty() && name != "." && name != ".."; }

/// "images/NAME" or "crops/NAME" with a plain name: nothing else is ever a comparison's.
bool IsOfComparison(const fs::path& path) {
    const fs::path folder = path.parent_path();
    return (folder == "images" || folder == "crops") && IsPlainName(path.filename());
}

/// "NAME.png" or "NAME.exr".
bool IsOfSurvey(const fs::path& path) {
    return !path.has_parent_path() && IsPlainName(path) &&
           (path.extension() == ".png" || path.extension() == ".exr");
}

/// The texts of "files" in a JSON file that has `schema`.
std::set<std::string> ListedFiles(const fs::path& json, const char* schema, bool (*isOurs)(const fs::path&)) {
    std::ifstream in(json);
    const auto results = nlohmann::json::parse(in, nullptr, false);
    std::set<std::string> files;
    if (!results.is_object() || results.value("schema", nlohmann::json()) != schema) return files;
    const auto list = results.find("files");
    if (list == results.end() || !list->is_array()) return files;
    for (const auto& file : *list)
        if (file.is_string() && isOurs(file.get<std::string>())) files.insert(file.get<std::string>());
    return files;
}

}  // namespace

std::set<std::string> FilesOfEarlierComparison(const std::string& folder) {
    return ListedFiles(fs::path(folder) / "results.json", "lacquer-compare-1", IsOfComparison);
}

std::set<std::string> FilesOfEarlierSurvey(const std::string& folder) {
    return ListedFiles(fs::path(folder) / "table.json", "lacquer-bsdf-1", IsOfSurvey);
}

void RemoveEarlierFiles(const std::string& folder, const std::set<std::string>& earlier,
                        const nlohmann::ordered_json& results, std::set<std::string> kept) {
    for (const auto& file : results["files"]) kept.insert(file.get<std::string>());
    for (const std::string& file : earlier) {
        std::error_code error;
        if (!kept.contains(file)) fs::remove(fs::path(folder) / file, error);
    }
}

}  // namespace lacquer::cmd
