// Cells around random points, on a square that wraps around.
#pragma once

#include "materialgan/procedural/fractal_noise.h"

namespace lacquer::materialgan {

struct CellMap {
    std::vector<int> index;  ///< of the nearest point
    Field first, second;     ///< distances to the two nearest points, of the edge
};

/// [Worley 1996]. @param count  of the points, at least 2
CellMap MakeCells(int size, int count, Rng& rng);

}  // namespace lacquer::materialgan
