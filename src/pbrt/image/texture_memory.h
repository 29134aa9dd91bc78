// The budget of image textures.
#pragma once

#include <cstddef>
#include <string>

namespace lacquer {

/// How much memory image textures may take, and where those that need more are kept on disk.
struct TextureMemory {
    /// Bytes. Larger images, and those that come when three quarters are taken, are read tile by tile.
    size_t bytes = size_t(512) << 20;
    /// Keeps tiled files from render to render; empty: none does.
    std::string cacheFolder;
    /// Where a folder for tiled files is made if they cannot be kept; it is removed at the end. Empty as well
    /// as `cacheFolder`: all images stay in memory.
    std::string temporaryFolder;
};

}  // namespace lacquer
