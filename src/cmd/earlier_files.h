// What an earlier run of a command left in its folder, and the new one does not write again.
#pragma once

#include <nlohmann/json.hpp>
#include <set>
#include <string>

namespace lacquer::cmd {

/// The images that the results.json of a comparison lists as its own, as paths inside the folder: files of
/// "images" and "crops", whatever else the list has. None where there is no such list.
std::set<std::string> FilesOfEarlierComparison(const std::string& folder);
/// Those that the table.json of `lacquer bsdf` lists: images in the folder itself.
std::set<std::string> FilesOfEarlierSurvey(const std::string& folder);

/// Removes those of `earlier` that neither results["files"] nor `kept` lists: references that a variant still
/// to come may take again. What cannot be removed stays.
void RemoveEarlierFiles(const std::string& folder, const std::set<std::string>& earlier,
                        const nlohmann::ordered_json& results, std::set<std::string> kept = {});

}  // namespace lacquer::cmd
