// Checkpoints of `lacquer bulk`.
#include <cstring>

#include "cmd/bulk/checkpoint.h"
#include "fuzz/fuzz_target.h"
#include "pbrt/core/hash_bytes.h"

namespace lacquer::fuzz {
namespace {

// The hashes of the problem and of all, at the end, made right, which no mutation does; the layout is that of
// cmd/bulk/checkpoint.cpp.
std::string WithHashes(std::string_view bytes) {
    constexpr size_t kMagic = 20;
    std::string checkpoint(bytes);
    const auto write = [&](size_t at, uint64_t hash) { std::memcpy(&checkpoint[at], &hash, sizeof hash); };
    if (checkpoint.size() < kMagic + 3 * sizeof(uint64_t)) return checkpoint;
    write(kMagic, HashOfBytes("problem"));
    const size_t end = checkpoint.size() - sizeof(uint64_t);
    write(end, HashOfBytes(std::string_view(checkpoint).substr(0, end)));
    return checkpoint;
}

void BulkCheckpoint(std::string_view bytes) {
    const InputFolder folder;
    const cmd::BulkStates states = cmd::ReadCheckpoint(folder.Write("a.part", WithHashes(bytes)), "problem");
    cmd::WriteCheckpoint(folder.Path() + "/b.part", "problem", states);
    Require(cmd::ReadCheckpoint(folder.Path() + "/b.part", "problem").size() == states.size(),
            "a checkpoint that is written is read again");
}

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "bulk_checkpoint", BulkCheckpoint);

}  // namespace lacquer::fuzz
