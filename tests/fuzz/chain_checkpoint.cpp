// Checkpoints of `lacquer estimate`.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "estimate/output/checkpoint.h"
#include "fuzz/fuzz_target.h"
#include "pbrt/core/hash_bytes.h"

namespace lacquer::fuzz {
namespace {

// The version and the checksum made right, which no mutation does; the layout is that of
// estimate/output/checkpoint.cpp.
std::string WithVersionAndChecksum(std::string_view bytes) {
    nlohmann::json json = nlohmann::json::parse(bytes, nullptr, false);
    if (!json.is_object()) return std::string(bytes);
    json["lacquer_checkpoint"] = 2;
    json.erase("checksum");
    using ErrorHandler = nlohmann::json::error_handler_t;
    const std::string rest = json.dump(-1, ' ', false, ErrorHandler::replace);
    json["checksum"] = fmt::format("{:016x}", HashOfBytes(rest));
    return json.dump(-1, ' ', false, ErrorHandler::replace);
}

// Settings are compared before anything else is looked at: as the seeds have them.
void ChainCheckpoint(std::string_view bytes) {
    estimate::ParseCheckpoint(WithVersionAndChecksum(bytes), "checkpoint.json", "settings");
}

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "chain_checkpoint", ChainCheckpoint);

}  // namespace lacquer::fuzz
