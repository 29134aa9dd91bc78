#include "measure/scene_material.h"

#include "pbrt/scene/parser.h"

namespace lacquer::measure {

SceneMaterial LoadMaterial(const std::string& path, const std::string& name, Point2 uv,
                           const BuildOptions& options, Observer* observer) {
    return LoadMaterial(ParseFile(path, observer), name, uv, options, observer);
}

SceneMaterial LoadMaterial(SceneDescription description, const std::string& name, Point2 uv,
                           const BuildOptions& options, Observer* observer) {
    SceneMaterial result;
    result.setup = BuildMaterial(std::move(description), name, options, observer);
    result.bsdf = std::make_unique<BsdfSubject>(*result.setup.material, uv, result.setup.entity.loc);
    return result;
}

}  // namespace lacquer::measure
