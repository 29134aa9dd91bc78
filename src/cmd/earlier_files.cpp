#include "cmd/compare/earlier_files.h"

#include <filesystem>
#include <fstream>

namespace lacquer::cmd {

namespace {

namespace fs = std::filesystem;

/// "images/NAME" or "crops/NAME" with a plain name: nothing else is ever ours.
bool IsOurs(const fs::path& path) {
    const fs::path folder = path.parent_path(), name = path.filename();
    return (folder == "images" || folder == "crops") && !name.empty() && name != "." && name != "..";
}

}  // namespace

std::set<std::string> FilesOfEarlierComparison(const std::string& folder) {
    std::ifstream in(fs::path(folder) / "results.json");
    const auto results = nlohmann::json::parse(in, nullptr, false);
    std::set<std::string> files;
    if (!results.is_object() || results.value("schema", nlohmann::json()) != "lacquer-compare-1")
        return files;
    const auto list = results.find("files");
    if (list == results.end() || !list->is_array()) return files;
    for (const auto& file : *list)
        if (file.is_string() && IsOurs(file.get<std::string>())) files.insert(file.get<std::string>());
    return files;
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
