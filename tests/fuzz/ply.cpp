// PLY files, zipped ones as well.
#include "fuzz/fuzz_target.h"
#include "pbrt/shapes/ply_reader.h"

namespace lacquer::fuzz {
namespace {

void Ply(std::string_view bytes) { ReadPly(InputFile(bytes).Path(), {}); }

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "ply", Ply);

}  // namespace lacquer::fuzz
