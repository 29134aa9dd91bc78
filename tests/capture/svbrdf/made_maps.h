// Maps and views that tests make up.
#pragma once

#include <vector>

#include "capture/maps.h"
#include "capture/svbrdf/rectified_image.h"
#include "capture/views.h"

namespace lacquer::capture::test {

/// Two materials, each a dielectric or a metal, with smooth variations and bumps.
enum class Pattern {
    Patches,  ///< with edges along noise
    Tiles,    ///< and the joints between them
    Waves     ///< one passing into the other
};
Maps MadeMaps(int size, Pattern pattern, uint64_t seed);
/// Maps of numbers without any connection, uniform but for normals, which lie within 45 degrees or so.
Maps RandomMaps(int size, uint64_t seed);

/// Views of a square of 6.848 cm with the light at the camera, 16 cm above: 1, 3, 5 or 9 of a 3 x 3 grid 2.5
/// cm apart.
ViewSet GridViews(int count);
/// Four with the light at the camera, 14 cm above and off that grid, and four with the light alone 6 cm
/// aside.
std::vector<View> NovelViews();

std::vector<RectifiedImage> RenderViews(const Maps& maps, const ViewSet& views);
/// Root mean square over all novel views of the difference of what two maps show.
double NovelRmse(const Maps& a, const Maps& b, const ViewSet& views);

}  // namespace lacquer::capture::test
