#include "cmd/preview/preview_scene.h"

#include <fmt/format.h>

#include <charconv>

#include "pbrt/core/embedded.h"
#include "pbrt/core/words.h"
#include "pbrt/scene/parser.h"

namespace lacquer {

extern const EmbeddedFile kPreviewFiles[];

namespace cmd {

namespace {

constexpr const char* kPlace = "preview material";

/// The name as shapes refer to it.
MaterialRef Find(const SceneDescription& scene, const std::string& name) {
    for (const MaterialEntity& m : scene.namedMaterials)
        if (m.name == name) return {0, name};
    int number = 0;
    if (name.starts_with("@")) {
        const char* end = name.data() + name.size();
        const auto [rest, error] = std::from_chars(name.data() + 1, end, number);
        if (error == std::errc() && rest == end && number >= 1 && size_t(number) < scene.materials.size())
            return {number, ""};
    }
    std::vector<std::string> names;
    for (const MaterialEntity& m : scene.namedMaterials) names.push_back(m.name);
    for (size_t i = 1; i < scene.materials.size(); ++i) names.push_back(fmt::format("@{}", i));
    throw SceneError({}, fmt::format("no material \"{}\"{}", Excerpt(name), DidYouMean(name, names)));
}

/// Entities of the stage find their files where its own resolver says.
template <class Entities>
void Append(Entities from, int firstDirectory, Entities* to) {
    for (auto& entity : from) {
        entity.directory += firstDirectory;
        to->push_back(std::move(entity));
    }
}

}  // namespace

void CheckMaterial(const SceneDescription& scene, const std::string& name) { Find(scene, name); }

std::string LastMaterial(const SceneDescription& scene) {
    // The first unnamed one is the default, which no directive made.
    if (scene.materials.size() > 1) return fmt::format("@{}", scene.materials.size() - 1);
    if (scene.namedMaterials.empty()) throw SceneError({}, "the scene has no material to show");
    return scene.namedMaterials.back().name;
}

SceneDescription OnStage(SceneDescription scene, const std::string& material) {
    const MaterialRef shown = Find(scene, material);
    SceneDescription stage = ParseText(std::string(EmbeddedData(kPreviewFiles, "preview/ball.pbrt")),
                                       "the stage of previews", "", nullptr);
    const auto firstDirectory = int(scene.resolvers.size());
    for (ShapeEntity& shape : stage.shapes)
        if (shape.material.name == kPlace) shape.material = shown;
    // The stage's own placeholder goes, should the scene have a material of that name.
    std::erase_if(stage.namedMaterials, [](const MaterialEntity& m) { return m.name == kPlace; });

    Append(std::move(stage.textures), firstDirectory, &scene.textures);
    Append(std::move(stage.namedMaterials), firstDirectory, &scene.namedMaterials);
    scene.areaLights.clear();
    Append(std::move(stage.areaLights), firstDirectory, &scene.areaLights);
    scene.lights.clear();
    Append(std::move(stage.lights), firstDirectory, &scene.lights);
    scene.shapes.clear();
    Append(std::move(stage.shapes), firstDirectory, &scene.shapes);
    scene.objects.clear();
    scene.instances.clear();
    scene.media.clear();
    scene.camera = std::move(stage.camera);
    scene.film = std::move(stage.film);
    scene.sampler = std::move(stage.sampler);
    scene.filter = std::move(stage.filter);
    scene.integrator = std::move(stage.integrator);
    for (PluginEntity* entity : {static_cast<PluginEntity*>(&scene.camera), &scene.film, &scene.sampler,
                                 &scene.filter, &scene.integrator})
        entity->directory += firstDirectory;
    scene.options = std::move(stage.options);
    scene.startTime = stage.startTime;
    scene.endTime = stage.endTime;
    scene.coordinateSystems = std::move(stage.coordinateSystems);
    scene.resolvers.insert(scene.resolvers.end(), stage.resolvers.begin(), stage.resolvers.end());
    return scene;
}

}  // namespace cmd

}  // namespace lacquer
