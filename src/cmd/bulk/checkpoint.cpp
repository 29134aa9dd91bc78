#include "cmd/bulk/checkpoint.h"

#include <cstring>

#include "cmd/command_support.h"
#include "pbrt/core/error.h"
#include "pbrt/core/file_bytes.h"
#include "pbrt/core/hash_bytes.h"

namespace lacquer::cmd {
namespace {

// The file: kMagic, a hash of the problem, the number of states; of each its length and its numbers; a hash
// of all before it. Lengths and hashes have 64 bits.
constexpr std::string_view kMagic = "lacquer-bulk-part 1\n";

void Append(std::string* text, uint64_t number) {
    text->append(reinterpret_cast<const char*>(&number), sizeof number);
}

}  // namespace

void WriteCheckpoint(const std::string& path, std::string_view problem, const BulkStates& states) {
    std::string text(kMagic);
    Append(&text, HashOfBytes(problem));
    Append(&text, states.size());
    for (const std::vector<double>& state : states) {
        Append(&text, state.size());
        text.append(reinterpret_cast<const char*>(state.data()), state.size() * sizeof(double));
    }
    Append(&text, HashOfBytes(text));
    WriteText(path, text);
}

BulkStates ReadCheckpoint(const std::string& path, std::string_view problem) {
    const FileBytes bytes = ReadFileBytes(path, {}, {.maxBytes = size_t(16) << 30});
    std::string_view rest = bytes.View();
    if (!rest.starts_with(kMagic)) throw FileError(path, "is no checkpoint of lacquer bulk");
    const auto damaged = [&] { return FileError(path, "this checkpoint is damaged"); };
    if (rest.size() < kMagic.size() + 3 * sizeof(uint64_t)) throw damaged();
    uint64_t hash = 0;
    std::memcpy(&hash, rest.data() + rest.size() - sizeof hash, sizeof hash);
    rest.remove_suffix(sizeof hash);
    if (HashOfBytes(rest) != hash) throw damaged();
    rest.remove_prefix(kMagic.size());
    const auto take = [&] {
        uint64_t number = 0;
        if (rest.size() < sizeof number) throw damaged();
        std::memcpy(&number, rest.data(), sizeof number);
        rest.remove_prefix(sizeof number);
        return number;
    };
    if (take() != HashOfBytes(problem))
        throw FileError(path,
                        "this checkpoint is of other particles, wavelengths or seed, or of another version "
                        "of the program; without this file the work begins anew");
    BulkStates states(std::min<uint64_t>(take(), rest.size()));
    for (std::vector<double>& state : states) {
        const uint64_t size = take();
        if (size > rest.size() / sizeof(double)) throw damaged();
        state.resize(size);
        std::memcpy(state.data(), rest.data(), size * sizeof(double));
        rest.remove_prefix(size * sizeof(double));
    }
    return states;
}

}  // namespace lacquer::cmd
