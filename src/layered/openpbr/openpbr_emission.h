// The light that OpenPBR surfaces emit.
#pragma once

#include <optional>

#include "pbrt/core/params.h"

namespace lacquer::layered {

/// Parameters of the area light "diffuse" that `emission_luminance` and `emission_color` make of a shape;
/// none where nothing is emitted. Textures of them are reported in `warnings` and emit nothing.
/// @param opacity  part of the surface that is there, and so emits
/// @param isThin   the surface is a sheet, and emits from both sides
/// Errors: SceneError for a negative luminance.
std::optional<Params> ReadOpenPBREmission(const Params& params, float opacity, bool isThin,
                                          std::vector<Diagnostic>& warnings);

}  // namespace lacquer::layered
