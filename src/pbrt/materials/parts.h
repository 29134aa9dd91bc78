// Materials that others are made of: the coats and bases of the coated ones.
#pragma once

#include "pbrt/base/material.h"
#include "pbrt/materials/roughness.h"
#include "pbrt/materials/thin_film_textures.h"

namespace lacquer {

/// A dielectric whose index the stack around it says. @param multiscatter  as the material's parameter
std::unique_ptr<Material> MakeDielectricPart(const RoughnessTextures& roughness, bool multiscatter);

/// A conductor, from the parameters of the material of that name but for those of the frame. `prefix` stands
/// before the names of the index and the roughness, as in "conductor.eta". "multiscatter" has none, and
/// `film` has been read. Errors: SceneError where both an index and a reflectance are given.
std::unique_ptr<Material> MakeConductorPart(const Params& params, TextureLibrary& textures,
                                            const std::string& prefix = "",
                                            const ThinFilmTextures& film = {});

/// A Lambertian surface: `reflectance`.
std::unique_ptr<Material> MakeDiffusePart(const Params& params, TextureLibrary& textures);

}  // namespace lacquer
