#include "pbrt/scene/description.h"

#include <fmt/format.h>

namespace lacquer {

namespace {

Params Combine(const PluginEntity& entity, std::vector<Parameter> parameters, const std::string& what,
               const FileResolver& files) {
    if (entity.attributes)
        parameters.insert(parameters.end(), entity.attributes->begin(), entity.attributes->end());
    return Params(fmt::format("{} \"{}\"", what, entity.type), entity.loc, std::move(parameters),
                  entity.colorSpace, files);
}

}  // namespace

// What pbrt-v4 takes where the option block says nothing.
SceneDescription::SceneDescription() : resolvers(1) {
    camera.type = "perspective";
    film.type = "rgb";
    sampler.type = "zsobol";
    filter.type = "gaussian";
    integrator.type = "volpath";
    accelerator.type = "bvh";
    MaterialEntity material;
    material.type = "diffuse";
    materials.push_back(std::move(material));
    for (PluginEntity* entity : {static_cast<PluginEntity*>(&camera), &film, &sampler, &filter, &integrator,
                                 &accelerator, static_cast<PluginEntity*>(&materials[0])})
        entity->colorSpace = &lacquer::ColorSpace::SRGB();
}

Params MakeParams(const PluginEntity& entity, const std::string& what, const FileResolver& files) {
    return Combine(entity, entity.parameters, what, files);
}

Params MakeParams(PluginEntity&& entity, const std::string& what, const FileResolver& files) {
    std::vector<Parameter> parameters = std::move(entity.parameters);
    return Combine(entity, std::move(parameters), what, files);
}

}  // namespace lacquer
