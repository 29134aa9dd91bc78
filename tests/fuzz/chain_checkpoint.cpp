// Checkpoints of `lacquer estimate`.
#include "estimate/output/checkpoint.h"
#include "fuzz/fuzz_target.h"

namespace lacquer::fuzz {
namespace {

// Settings are compared before anything else is looked at: as the seeds have them.
void ChainCheckpoint(std::string_view bytes) {
    estimate::ParseCheckpoint(std::string(bytes), "checkpoint.json", "settings");
}

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "chain_checkpoint", ChainCheckpoint);

}  // namespace lacquer::fuzz
