// EXR files, as all images are read.
#include "fuzz/fuzz_target.h"
#include "pbrt/image/image.h"

namespace lacquer::fuzz {
namespace {

// Also as the rows that textures on disk are made of.
void Exr(std::string_view bytes) { ReadImage(InputFile(bytes).Path(), {}, {}); }

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "exr", Exr);

}  // namespace lacquer::fuzz
