// Tables of Gaussian lobes (gaussfit).
#include <fmt/format.h>

#include <array>

#include "fuzz/fuzz_target.h"
#include "gaussfit/lobe/lobe_table.h"

namespace lacquer::fuzz {
namespace {

using gaussfit::LobeTable;

// The checksum at the end made right (docs/gaussfit.md), which no mutation does: FNV-1a of all before its
// line.
std::string WithChecksum(std::string_view bytes) {
    constexpr std::string_view kKey = "\nchecksum ";
    const size_t at = bytes.rfind(kKey);
    if (at == std::string_view::npos) return std::string(bytes);
    uint64_t hash = 0xcbf29ce484222325;
    for (const char c : bytes.substr(0, at + 1)) hash = (hash ^ uint8_t(c)) * 0x100000001b3;
    return fmt::format("{}{}{:016x}\n", bytes.substr(0, at), kKey, hash);
}

void LobeTableText(std::string_view bytes) {
    const LobeTable table = LobeTable::Parse(WithChecksum(bytes), "table.txt");
    const std::string text = table.ToText();
    Require(LobeTable::Parse(text, "table.txt").ToText() == text, "a table that is written is read again");
    std::array<gaussfit::LobeShape<float>, LobeTable::kMaxComponents> shapes;
    std::array<float, LobeTable::kMaxComponents> weights{};
    table.Find({0.3f, 1.5f, 0.7f}, &shapes, &weights);
}

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "lobe_table", LobeTableText);

}  // namespace lacquer::fuzz
