// Files of lenses, focused.
#include "fuzz/fuzz_target.h"
#include "pbrt/cameras/realistic_lens.h"

namespace lacquer::fuzz {
namespace {

void LensFile(std::string_view bytes) {
    const std::vector<LensSurface> surfaces = ReadLensFile(InputFile(bytes).Path(), {});
    LensSystem lens(surfaces, 5);
    lens.Cardinals();
    lens.Focus(2000);
    LensRays rays{};
    rays.dz += 1;
    lens.Trace(&rays, LensRays::kCount, LensSystem::Stops::Block);
}

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "lens_file", LensFile);

}  // namespace lacquer::fuzz
