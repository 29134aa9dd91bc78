// views.json, what `lacquer capture` reads and writes.
#include "capture/svbrdf/views_file.h"
#include "fuzz/fuzz_target.h"

namespace lacquer::fuzz {
namespace {

void Views(std::string_view bytes) { capture::ReadViews(InputFile(bytes).Path()); }

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "views", Views);

}  // namespace lacquer::fuzz
