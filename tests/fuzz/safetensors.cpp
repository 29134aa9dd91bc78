// Files of tensors (safetensors), as summaries by a network read them.
#include <array>

#include "estimate/summary/safetensors.h"
#include "fuzz/fuzz_target.h"

namespace lacquer::fuzz {
namespace {

void Safetensors(std::string_view bytes) {
    const estimate::TensorFile file(InputFile(bytes).Path());
    const std::array<size_t, 2> shape = {2, 3};
    file.Read("weight", shape);
}

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "safetensors", Safetensors);

}  // namespace lacquer::fuzz
