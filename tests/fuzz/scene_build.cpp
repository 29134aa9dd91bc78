// Objects of tiny scenes, and an image of a few pixels: what is beyond the parser. Film and samples are
// bounded.
#include <optional>

#include "fuzz/fuzz_target.h"
#include "pbrt/integrators/render.h"
#include "pbrt/scene/builder.h"
#include "pbrt/scene/parser.h"

namespace lacquer::fuzz {
namespace {

void SceneBuild(std::string_view bytes) {
    SceneDescription description = ParseText(std::string(bytes), "scene.pbrt", "/nonexistent", nullptr);
    Observer observer;
    BuildOptions options;
    options.film.resolution = Int2(4, 3);
    options.samplesPerPixel = 1;
    BuildScene(std::move(description), options, &observer);
}

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "scene_build", SceneBuild);

}  // namespace lacquer::fuzz
