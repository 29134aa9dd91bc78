// From a scene description to the objects that render.
#pragma once

#include <memory>
#include <optional>

#include "pbrt/base/film.h"
#include "pbrt/base/integrator.h"
#include "pbrt/base/material.h"
#include "pbrt/core/phase_times.h"
#include "pbrt/core/progress.h"
#include "pbrt/image/texture_memory.h"
#include "pbrt/scene/description.h"
#include "pbrt/scene/scene.h"

namespace lacquer {

struct AssetCache;

/// What the command line says about a scene; scene_options.h says where it wins over the file.
struct BuildOptions {
    GivenOptions given;
    FilmOverrides film;
    std::optional<int> samplesPerPixel;
    /// Above 1: RenderSetup::longSampler can give a pixel so many times the samples per pixel. Samplers whose
    /// values depend on the number of samples spread them over all of these.
    int maxTimes = 1;
    /// Samples per pixel that textures are filtered for: the more there are, the narrower; 64 and more are
    /// alike. Unset: the sampler's.
    std::optional<int> filterSamples;
    bool keepNames = false;             ///< fill Scene::Names()
    bool disableImageTextures = false;  ///< image textures have their mean everywhere
    MaterialOverrides materials;
    TextureMemory textures;
    /// Files that scenes before have read, and those after will find; null: all are read. Counts the memory
    /// of textures for all of them, in place of `textures`.
    std::shared_ptr<AssetCache> assets;
};

/// Everything that a render needs. The integrator refers to the scene.
struct RenderSetup {
    std::unique_ptr<Scene> scene;
    std::unique_ptr<Film> film;
    std::unique_ptr<Sampler> sampler;
    std::unique_ptr<Sampler> longSampler;  ///< for renders that give some pixels more than others; or null
    std::unique_ptr<Integrator> integrator;
    int samplesPerPixel = 0;  ///< to take
    int plannedSamples = 0;   ///< when the render began; a resumed one may have more to take
    Transform renderFromWorld;
    SceneOptions options;  ///< in force
    /// Of the numbers that paths draw beside the sampler's: the option's seed, and where the scene gives the
    /// sampler one of its own, both. So renders of different seeds of either kind are independent.
    int generatorSeed = 0;
    std::vector<FileUse>
        files;  ///< what directives have read, in the order of building; several times if used so
    std::vector<PhaseTime> phases;  ///< of building
};

/// Names of `Accelerator`: both mean the one that there is.
const std::vector<std::string>& AcceleratorNames();

/// Makes the objects that a description names, loads the files they need, and builds the acceleration
/// structure. Errors: SceneErrors with everything that is wrong, in the order of the file.
RenderSetup BuildScene(SceneDescription description, const BuildOptions& options, Observer* observer);

/// One material with all that it refers to.
struct MaterialSetup {
    std::shared_ptr<TextureLibrary> textures;
    std::vector<std::unique_ptr<Material>> owned;
    const Material* material = nullptr;  ///< one of `owned`
    MaterialEntity entity;               ///< what the scene says about it, without its parameters
};

/// Makes one material of a description, and of the rest only the materials and textures that it needs.
/// @param name  of a named material, or "@1", "@2", ... for the unnamed ones in the order of the file;
///              "@0" is the diffuse default
///
/// Errors: SceneError for an unknown name (with the nearest one) and for what is no surface; else as
/// BuildScene.
MaterialSetup BuildMaterial(SceneDescription description, const std::string& name,
                            const BuildOptions& options, Observer* observer);

}  // namespace lacquer
