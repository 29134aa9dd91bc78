// Numbers of a scene that are estimated, by their names: "coat.roughness".
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "estimate/parameters.h"
#include "pbrt/scene/description.h"

namespace lacquer::estimate {

/// One of them.
struct SceneParameter {
    std::string name;       ///< as it was asked for
    std::string material;   ///< "coat", or "@1" for the first unnamed material; empty: the exposure
    std::string parameter;  ///< of that material: "roughness"
    /// Of a colour: 0, 1, 2 for its r, g, b; -1: all of them keep their ratios and the number is their mean,
    /// as it is of the values of a spectrum.
    int channel = -1;
    double start = 0;  ///< in the file, or the parameter's default
    std::string meaning;
};

/// Name of a free parameter of photographs: what the scene's values are multiplied by.
inline constexpr const char* kExposureName = "exposure";

/// Free parameters of one material of a scene, or of materials that it is made of.
class SceneParameters {
  public:
    /// @param scene     what it takes of it, it keeps: materials and textures
    /// @param material  whose light is measured: a name, or "@1" ...
    /// @param names     MATERIAL.PARAMETER, or MATERIAL.PARAMETER.r for one channel of a colour;
    /// kExposureName
    /// @param priors    in place of the default ones, by such names
    /// Errors: SceneError at its place for a name that is not there (with the nearest one), a material that
    /// `material` does not need, and a parameter that is a texture, a named spectrum, or no number, or that
    /// is there twice (once as a whole and once as a channel), and a prior beyond what materials can have;
    /// without a prior, for one without a default
    /// range or whose value lies outside of it.
    SceneParameters(SceneDescription scene, std::string material, const std::vector<std::string>& names,
                    const std::map<std::string, Prior>& priors);

    const ParameterSpace& Space() const { return space_; }
    const std::vector<SceneParameter>& All() const { return parameters_; }
    /// Place of the exposure among them, if it is free.
    std::optional<size_t> Exposure() const { return space_.Find(kExposureName); }
    const std::string& Material() const { return material_; }
    /// Values of the file, moved inside of their bounds.
    Vector Start() const;
    /// The scene's materials and textures with these values. @param x  natural units
    SceneDescription With(const Vector& x) const;
    /// Names of the materials that `material` needs, in the order of the file, itself at the end.
    const std::vector<std::string>& Needed() const { return needed_; }

  private:
    SceneDescription scene_;
    std::string material_;
    std::vector<std::string> needed_;
    std::vector<SceneParameter> parameters_;
    ParameterSpace space_{{}};
};

/// The only layered material of a scene. Errors: SceneError, if there are more or none.
std::string OnlyLayeredMaterial(const SceneDescription& scene);

/// The entity of a name, or null.
MaterialEntity* FindMaterialEntity(const std::string& name, SceneDescription* scene);

}  // namespace lacquer::estimate
