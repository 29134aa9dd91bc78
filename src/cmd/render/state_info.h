// lacquer info, of states.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "cmd/render/state_header.h"

namespace lacquer::cmd {

struct StateInfo {
    std::string path;
    StateHeader header;
    uint64_t bytes = 0;     ///< of the file
    double ageSeconds = 0;  ///< since it was written
};
/// Reads all of the file, so that what is damaged is found. Errors: FileError.
StateInfo ReadStateInfo(const std::string& path);
nlohmann::json StateInfoJson(const StateInfo& info);
std::string StateInfoText(const StateInfo& info);

}  // namespace lacquer::cmd
