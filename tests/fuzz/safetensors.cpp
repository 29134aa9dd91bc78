// Files of tensors (safetensors), as those that have weights of a network read them: each tensor with the
// shape that its file says, and one with a shape that the reader wants.
#include <array>

#include "fuzz/fuzz_target.h"
#include "pbrt/image/safetensors.h"

namespace lacquer::fuzz {
namespace {

void Safetensors(std::string_view bytes) {
    const SafetensorsFile file(InputFile(bytes).Path());
    for (const std::string& name : file.Names()) {
        try {
            file.Read(name, file.ShapeOf(name));
        } catch (const FileError&) {  // the others are still to be read
        }
    }
    const std::array<size_t, 2> shape = {2, 3};
    file.Read("weight", shape);
}

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "safetensors", Safetensors);

}  // namespace lacquer::fuzz
