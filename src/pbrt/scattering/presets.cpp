#include "pbrt/scattering/presets.h"

#include <utility>

#include "pbrt/core/check.h"
#include "pbrt/core/embedded.h"

namespace lacquer {
namespace {

constexpr const char* kFile = "scattering/presets.txt";

struct PresetTable {
    std::vector<std::string> names;
    std::vector<ScatteringPreset> presets;

    PresetTable() {
        // A line is a name, a colon, and the numbers; names contain blanks.
        std::string_view text = EmbeddedData(kFile);
        while (!text.empty()) {
            const std::string_view line = text.substr(0, text.find('\n'));
            text.remove_prefix(std::min(line.size() + 1, text.size()));
            if (!line.starts_with('#')) names.emplace_back(line.substr(0, line.find(':')));
        }
        for (const std::vector<double>& row : EmbeddedTable(kFile)) {
            LACQUER_CHECK(row.size() == 6);
            presets.push_back({RGB(row[0], row[1], row[2]), RGB(row[3], row[4], row[5])});
        }
        LACQUER_CHECK(names.size() == presets.size());
    }
};

const PresetTable& Table() {
    static const PresetTable table;
    return table;
}

}  // namespace

std::optional<ScatteringPreset> FindScatteringPreset(std::string_view name) {
    const PresetTable& table = Table();
    for (size_t i = 0; i < table.names.size(); ++i)
        if (table.names[i] == name) return table.presets[i];
    return std::nullopt;
}

std::vector<std::string> ScatteringPresetNames() { return Table().names; }

}  // namespace lacquer
