// Files of phase functions.
#include "fuzz/fuzz_target.h"
#include "pbrt/phases/table_file.h"

namespace lacquer::fuzz {
namespace {

void PhaseTableFile(std::string_view bytes) { ReadPhaseTableFile(InputFile(bytes).Path(), {}); }

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "phase_table", PhaseTableFile);

}  // namespace lacquer::fuzz
