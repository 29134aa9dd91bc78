// A NanoVDB grid with nodes of all levels, patched: whole ones are too large to be found by mutation of their
// bytes.
#include <string>

#include "fuzz/fuzz_target.h"
#include "pbrt/core/file_bytes.h"
#include "pbrt/media/nanovdb_file.h"
#include "support/nanovdb_library.h"

namespace lacquer::fuzz {
namespace {

std::string SmallFog() {
    const auto grid = nanovdb::createFogVolumeSphere<float>(
        2.5f, nanovdb::Vec3f(0.3f, -0.2f, 0.5f), 1.0, 1.5, nanovdb::Vec3d(0.01), "density",
        nanovdb::StatsMode::All, nanovdb::ChecksumMode::Disable);
    // The library writes the head last, over a gap, which a stream in memory need not allow.
    const InputFolder folder;
    const std::string path = folder.Path() + "/fog.nvdb";
    nanovdb::io::writeGrid(path, grid, nanovdb::io::Codec::NONE);
    return std::string(ReadFileBytes(path, {}, {.maxBytes = 1 << 28}).View());
}

void NanoVdbPatches(std::string_view bytes) {
    static const std::string fog = SmallFog();
    const InputFile input(Patched(fog, bytes));
    const NanoVdbFile file(input.Path(), {});
    for (const std::string& name : file.Names())
        for (const bool clamp : {false, true}) {
            const NanoVdbGrid grid = file.Read(name, clamp);
            grid.values.Lookup(grid.bounds.min + 0.3f * grid.bounds.Diagonal());
        }
}

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "nanovdb_patches", NanoVdbPatches);

}  // namespace lacquer::fuzz
