// A material of a scene file by itself, ready to be evaluated.
#pragma once

#include <memory>
#include <string>

#include "measure/bsdf_subject.h"
#include "pbrt/scene/builder.h"

namespace lacquer::measure {

/// A material, all that it refers to, and its BxDFs at one point.
struct SceneMaterial {
    MaterialSetup setup;
    std::unique_ptr<const BsdfSubject> bsdf;  ///< never null
};

/// Reads a scene file and makes one of its materials; of the rest only what this one needs.
/// @param name  as of BuildMaterial(): of a named material, or "@1", "@2", ... for the unnamed ones
/// @param uv  where its textures are looked up
/// @param options  estimator and density of layered materials, the seed of what the scene makes at random,
/// memory for textures; the rest has no effect
/// @param observer  gets the warnings; may be null
/// Errors: those of ParseFile(), BuildMaterial() and BsdfSubject: SceneErrors, SceneError, FileError.
SceneMaterial LoadMaterial(const std::string& path, const std::string& name, Point2 uv = Point2(0.5f),
                           const BuildOptions& options = {}, Observer* observer = nullptr);
/// The same of a scene that has been read.
SceneMaterial LoadMaterial(SceneDescription description, const std::string& name, Point2 uv = Point2(0.5f),
                           const BuildOptions& options = {}, Observer* observer = nullptr);

}  // namespace lacquer::measure
