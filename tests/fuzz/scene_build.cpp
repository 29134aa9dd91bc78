// Objects of tiny scenes, and an image of a few pixels: what is beyond the parser. What scenes may ask for in
// any amount is bounded: film, samples, levels of subdivision (docs/security.md).
#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "fuzz/fuzz_target.h"
#include "pbrt/integrators/render.h"
#include "pbrt/scene/builder.h"
#include "pbrt/scene/parser.h"

namespace lacquer::fuzz {
namespace {

void BoundLevels(std::vector<Parameter>* parameters) {
    constexpr int kMaxLevels = 5;
    for (Parameter& parameter : *parameters)
        if (parameter.name == "levels")
            for (int& levels : parameter.integers) levels = std::min(levels, kMaxLevels);
}
void BoundLevels(std::vector<ShapeEntity>* shapes) {
    for (ShapeEntity& shape : *shapes) {
        BoundLevels(&shape.parameters);
        if (!shape.attributes) continue;
        std::vector<Parameter> attributes = *shape.attributes;
        BoundLevels(&attributes);
        shape.attributes = std::make_shared<const std::vector<Parameter>>(std::move(attributes));
    }
}

void SceneBuild(std::string_view bytes) {
    SceneDescription description = ParseText(std::string(bytes), "scene.pbrt", "/nonexistent", nullptr);
    BoundLevels(&description.shapes);
    for (ObjectDefinition& object : description.objects) BoundLevels(&object.shapes);
    Observer observer;
    BuildOptions options;
    options.film.resolution = Int2(4, 3);
    options.samplesPerPixel = 1;
    BuildScene(std::move(description), options, &observer);
}

}  // namespace

LACQUER_REGISTER(FuzzTargetKind, "scene_build", SceneBuild);

}  // namespace lacquer::fuzz
