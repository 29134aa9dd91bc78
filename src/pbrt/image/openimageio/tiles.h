// OpenImageIO's cache of tiles as a TileStore.
#pragma once

#include <memory>

#include "pbrt/image/image_library.h"

namespace lacquer::openimageio {

std::unique_ptr<TileStore> MakeTiles();

}  // namespace lacquer::openimageio
