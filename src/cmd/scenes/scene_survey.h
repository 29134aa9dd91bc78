// What a scene holds, for `lacquer info`.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "cmd/scenes/scene_arguments.h"
#include "pbrt/core/vec.h"

namespace lacquer::cmd {

/// A material as a directive makes it.
struct MaterialUse {
    std::string name;            ///< "@1", "@2", ... for unnamed ones, as for `lacquer bsdf`
    std::string type, place;     ///< place: file:line:column of the directive
    int64_t shapes = 0;          ///< directives of shapes that have it
    bool isUsed = false;         ///< by a shape, or by a material that is used
    std::string estimator, pdf;  ///< of layered materials; else empty
};

struct TextureUse {
    std::string name, place;
    std::string value;      ///< "float" or "spectrum"
    std::string type;       ///< "imagemap", ...
    std::string file;       ///< of the image; empty if there is none, as all below
    Int2 resolution{0};     ///< as it is kept: filled up to powers of two
    size_t bytes = 0;       ///< of the pyramid, which textures of one image share
    bool isShared = false;  ///< an earlier texture of the list has the same one
};

/// An image that is no texture: of a light, a normal map.
struct ImageUse {
    std::string file, user;
    Int2 resolution{0};
    size_t bytes = 0;
};

struct ListedFile {
    std::string path, role;  ///< role: "scene", or what the directive makes that names it: "shape", ...
    uint64_t bytes = 0;      ///< 0 for standard input
};

struct MemoryForecast {
    size_t geometry = 0, accelerationStructure = 0, textures = 0, images = 0, media = 0, film = 0;
    size_t Total() const { return geometry + accelerationStructure + textures + images + media + film; }
};

struct SceneSurvey {
    std::string name, image;
    Int2 resolution{0};
    Bounds2i pixels;
    int samplesPerPixel = 0;
    std::string camera, film, filter, sampler, integrator, accelerator, colorSpace;

    std::map<std::string, int64_t> shapes, lights, areaLights, materialTypes, media;  ///< directives by type
    int64_t triangles = 0, otherPrimitives = 0;  ///< in memory; those of objects once
    int64_t objects = 0, instances = 0;
    int64_t placedPrimitives = 0;  ///< with those of objects as often as they are placed
    int64_t emitters = 0;          ///< primitives that are area lights
    std::vector<MaterialUse> materials;
    std::vector<TextureUse> textures;
    std::vector<ImageUse> images;
    std::vector<ListedFile> files;
    MemoryForecast memory;
    std::vector<std::string> warnings;  ///< of reading and building as well
};

/// Reads and builds the scene as for a render, which is all but the rendering. Errors: as there.
SceneSurvey SurveyScene(std::vector<SceneInput> inputs);

}  // namespace lacquer::cmd
