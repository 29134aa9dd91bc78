// NanoVDB files, uncompressed, zip and Blosc: all grids of a file.
#include "fuzz/fuzz_target.h"
#include "pbrt/media/nanovdb_file.h"

namespace lacquer::fuzz {
namespace {

void NanoVdb(std::string_view bytes) {
    const InputFile input(bytes);
    const NanoVdbFile file(input.Path(), {});
    for (const std::string& name : file.Names()) {
        const NanoVdbGrid grid = file.Read(name, true);
        Require(grid.values.Maximum() >= 0, "negative values are clamped");
        const Point3 inside = grid.bounds.min + 0.3f * grid.bounds.Diagonal();
        Require(grid.values.Lookup(inside) <= grid.values.Maximum(), "no value is above the largest one");
    }
}

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "nanovdb", NanoVdb);

}  // namespace lacquer::fuzz
