// What scene files say, in order and with places, before any object is made from it.
#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pbrt/core/params.h"
#include "pbrt/core/transform.h"
#include "pbrt/scene/scene_options.h"

namespace lacquer {

/// Parameters that Attribute directives have collected, oldest first; shared by all entities that they reach.
using AttributeList = std::shared_ptr<const std::vector<Parameter>>;

/// A directive that names a plugin: its type and its parameters.
struct PluginEntity {
    std::string type;                   ///< "diffuse", "trianglemesh", ...
    FileLoc loc;                        ///< of the directive
    std::vector<Parameter> parameters;  ///< as they stand in the file
    AttributeList attributes;           ///< may be null
    const lacquer::ColorSpace* colorSpace = nullptr;
    int directory = 0;  ///< index for SceneDescription::FilesOf
};

/// CTM at the start and at the end of the transform times; equal where nothing moves.
struct TransformPair {
    Transform start, end;
    bool IsAnimated() const { return !(start == end); }
};

struct CameraEntity : PluginEntity {
    TransformPair cameraFromWorld;
    float startTime = 0, endTime = 1;  ///< of the transform pair
    std::string medium;                ///< around the camera; empty: vacuum
};

struct TextureEntity : PluginEntity {  ///< `type` is the class: "imagemap", ...
    std::string name;
    bool isSpectrum = false;  ///< value type "spectrum", else "float"
    Transform worldFromTexture;
};

struct MaterialEntity : PluginEntity {
    std::string name;  ///< empty for the unnamed ones
};

struct MediumEntity : PluginEntity {
    std::string name;
    Transform worldFromMedium;
};

struct LightEntity : PluginEntity {
    Transform worldFromLight;
    std::string medium;  ///< around the light; empty: vacuum
};

/// A material as a shape selects it.
struct MaterialRef {
    int index = 0;     ///< in SceneDescription::materials, where `name` is empty
    std::string name;  ///< of a named material (the parser has checked that it exists)
};

struct ShapeEntity : PluginEntity {
    TransformPair worldFromObject;
    bool reverseOrientation = false;
    MaterialRef material;
    int areaLight = -1;                       ///< in SceneDescription::areaLights; -1: none
    std::string insideMedium, outsideMedium;  ///< empty: vacuum (the parser has checked that they exist)
};

struct ObjectDefinition {
    std::string name;
    FileLoc loc;
    std::vector<ShapeEntity> shapes;  ///< area lights are already dropped, with a warning
};

/// World point = pair * (the shape's own worldFromObject) * p.
struct InstanceEntity {
    std::string name;  ///< of the object (the parser has checked that it exists)
    FileLoc loc;
    TransformPair worldFromInstance;
};

/// A whole scene. The lists keep the order of the files; what an imported file makes comes where the
/// importing file ends. All names are unique in their list and all references resolve.
struct SceneDescription {
    /// The option block. Their types are pbrt's defaults where the file has no such directive.
    CameraEntity camera;
    PluginEntity film, sampler, filter, integrator, accelerator;
    GivenOptions options;
    /// Transform times for everything in the world block.
    float startTime = 0, endTime = 1;

    std::vector<TextureEntity> textures;
    std::vector<MaterialEntity> materials;  ///< unnamed ones; the first is the default, diffuse
    std::vector<MaterialEntity> namedMaterials;
    std::vector<MediumEntity> media;
    std::vector<LightEntity> lights;
    std::vector<PluginEntity> areaLights;  ///< one for each AreaLightSource directive
    std::vector<ShapeEntity> shapes;       ///< outside of object definitions
    std::vector<ObjectDefinition> objects;
    std::vector<InstanceEntity> instances;

    /// CTMs stored by CoordinateSystem, Camera ("camera", the inverse of the CTM) and WorldBegin ("world").
    std::map<std::string, TransformPair> coordinateSystems;
    /// In the order of the files, consecutive equal ones once; the observer has had them already.
    std::vector<Diagnostic> warnings;
    /// Scene files that were read, in their order; texts that are no files under their names.
    std::vector<std::string> files;
    /// One for each top-level file: where relative paths are looked for.
    std::vector<FileResolver> resolvers;

    SceneDescription();
    const FileResolver& FilesOf(const PluginEntity& entity) const {
        return resolvers[size_t(entity.directory)];
    }
};

/// The entity's own and inherited parameters, ready for look-ups.
/// @param what  the kind, for messages: "material" makes the owner `material "diffuse"`
/// Cost         copies the numbers; the second form moves the entity's own parameters out.
Params MakeParams(const PluginEntity& entity, const std::string& what, const FileResolver& files);
Params MakeParams(PluginEntity&& entity, const std::string& what, const FileResolver& files);

}  // namespace lacquer
