// Scene text, as the parser of `lacquer render` reads it. What it includes is looked for in a folder that is
// not there.
#include "fuzz/fuzz_target.h"
#include "pbrt/scene/parser.h"

namespace lacquer::fuzz {
namespace {

void ParsedText(std::string_view bytes) {
    ParseText(std::string(bytes), "scene.pbrt", "/nonexistent", nullptr);
}

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "scene_text", ParsedText);

}  // namespace lacquer::fuzz
