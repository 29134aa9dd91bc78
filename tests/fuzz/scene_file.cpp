// Scene files as `lacquer render` opens them: text or gzip data.
#include "fuzz/fuzz_target.h"
#include "pbrt/scene/parser.h"

namespace lacquer::fuzz {
namespace {

void SceneFile(std::string_view bytes) { ParseFile(InputFile(bytes).Path(), nullptr); }

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "scene_file", SceneFile);

}  // namespace lacquer::fuzz
