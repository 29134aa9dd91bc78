// particles.json, what `lacquer bulk` reads.
#include "bulk/input/particles_input.h"
#include "fuzz/fuzz_target.h"

namespace lacquer::fuzz {
namespace {

void Particles(std::string_view bytes) { bulk::ReadParticles(InputFile(bytes).Path()); }

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "particles", Particles);

}  // namespace lacquer::fuzz
