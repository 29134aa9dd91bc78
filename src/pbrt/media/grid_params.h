// Parameters that the media on grids share.
#pragma once

#include "pbrt/media/temperature_emission.h"
#include "pbrt/media/voxel_grid.h"

namespace lacquer {

/// From rendering space to the unit cube that stands for the box `"p0"` ... `"p1"` (default 0, 1) of medium
/// space. Errors: SceneError if the box has no volume.
Transform ReadUnitFromRender(const MediumArgs& args);

/// `"nx"`, `"ny"`, `"nz"` (default 1). Errors: SceneError if one is below 1, or there are more than 2^31
/// voxels.
Int3 ReadResolution(const Params& params);

/// Errors: SceneError at the parameter `name` unless it has one value for each voxel.
void CheckVoxelCount(const Params& params, const char* name, size_t count, Int3 resolution);

/// `"float name"` with one value, not negative, for each voxel; empty where absent. Errors: SceneError.
std::optional<FloatGrid> ReadFloatGrid(const Params& params, const char* name, Int3 resolution);

/// Lengths of the unit cube's edges in rendering space.
Vec3 EdgeLengths(const Transform& unitFromRender);

}  // namespace lacquer
