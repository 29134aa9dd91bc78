// HDR, PFM and the other simple formats, as all images are read.
#include "fuzz/fuzz_target.h"
#include "pbrt/image/image.h"

namespace lacquer::fuzz {
namespace {

void Hdr(std::string_view bytes) { ReadImage(InputFile(bytes).Path(), {ColorEncoding::Kind::SRGB, 1}, {}); }

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "hdr", Hdr);

}  // namespace lacquer::fuzz
