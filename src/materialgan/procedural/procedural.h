// Materials by formula, endlessly many: what a generator learns from, and what fits are tested with.
#pragma once

#include <cstdint>

#include "capture/maps.h"
#include "materialgan/procedural/reliefs.h"

namespace lacquer::materialgan {

/// Names the families and their distributions; changes with them.
inline constexpr const char* kProceduralRecipe = "lacquer-procedural-1";

/// Two homogeneous materials, a fifth of them metals, over the relief of a family. The same arguments give
/// the same maps.
/// @param size  texels along an edge, a power of two
capture::Maps ProceduralMaterial(Family family, int size, uint64_t seed);
/// One of any family but Dots, turned by quarters, shifted, and with colours exchanged.
capture::Maps TrainingMaterial(int size, uint64_t seed);

/// The sample turned by a quarter, counter-clockwise as seen from above; normals turn along.
capture::Maps QuarterTurn(const capture::Maps& maps);
/// The texel at (row, column) moves to (row + down, column + right), and wraps around.
capture::Maps Shift(const capture::Maps& maps, int down, int right);

}  // namespace lacquer::materialgan
