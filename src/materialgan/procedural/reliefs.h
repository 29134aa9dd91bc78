// Patterns of two materials: where each of them is, and how high it stands.
#pragma once

#include "materialgan/procedural/fractal_noise.h"

namespace lacquer::materialgan {

enum class Family { Patches, Tiles, Wood, Cells, Weave, Scratches, Plaster, Speckles, Ribs, Dots };
/// Those that a training sees; Dots is kept for tests of what it has not seen.
inline constexpr int kNumTrainedFamilies = 9, kNumFamilies = 10;
const char* FamilyName(Family family);

struct Relief {
    Field mask;    ///< share of the second material, in [0,1]
    Field height;  ///< of the size of 1/32 of the edge
    Field detail;  ///< of brightness, roughness and fine relief; of deviation about 1
};

/// @param size  texels along an edge, a power of two
Relief MakeRelief(Family family, int size, Rng& rng);

}  // namespace lacquer::materialgan
