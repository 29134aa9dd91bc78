// Files of bulk scattering.
#include <variant>

#include "fuzz/fuzz_target.h"
#include "pbrt/scattering/bulk_table.h"

namespace lacquer::fuzz {
namespace {

void BulkTableFile(std::string_view bytes) {
    const auto text = [](const auto& table) { return WriteBulkTable(table); };
    const std::string once = std::visit(text, ReadBulkFile(InputFile(bytes).Path()));
    std::string twice;
    try {
        twice = std::visit(text, ReadBulkFile(InputFile(once).Path()));
    } catch (const SceneError&) {
        return;  // nine digits need not be enough for numbers at the end of their range
    }
    Require(once == twice, "reading and writing a table again gives the same bytes");
}

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "bulk_table", BulkTableFile);

}  // namespace lacquer::fuzz
