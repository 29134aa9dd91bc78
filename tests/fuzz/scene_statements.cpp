// Scene text as the formatter of `lacquer convert` and its upgrade from pbrt-v3 read it.
#include "fuzz/fuzz_target.h"
#include "pbrt/scene/statements.h"
#include "pbrt/scene/v3_upgrade.h"

namespace lacquer::fuzz {
namespace {

// What is written is read again, and writing that changes nothing.
void RequireStable(const SceneText& scene) {
    const std::string once = WriteSceneText(scene);
    const std::string twice = WriteSceneText(ReadSceneText(SourceOf("written.pbrt", once)));
    Require(once == twice, "writing a scene text again changes nothing");
}

void SceneStatements(std::string_view bytes) {
    const Source source = SourceOf("scene.pbrt", std::string(bytes));
    RejectOtherThanText(source);
    SceneText scene = ReadSceneText(source);
    RequireStable(scene);
    UpgradeFromV3(&scene);
    WriteSceneText(scene);
}

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "scene_statements", SceneStatements);

}  // namespace lacquer::fuzz
