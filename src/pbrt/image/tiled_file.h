// A pyramid as a file of tiles: a TIFF file with an image for each level, which image viewers can show.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pbrt/image/pyramid.h"

namespace lacquer {

/// Texels a side of a tile.
inline constexpr int kTileSize = 64;

/// Where everything is in a file. Tiles are not compressed, so that this is known before the first is made.
class TiledLayout {
  public:
    /// @param description  kept in the file; plain text
    TiledLayout(Int2 image, const TexelFormat& format, std::string description);

    int NumLevels() const { return int(levels_.size()); }
    Int2 Resolution(int level) const { return levels_[size_t(level)]; }
    const TexelFormat& Format() const { return format_; }
    /// Tiles along both axes; those at the far edges may stick out.
    Int2 NumTiles(int level) const { return (Resolution(level) + kTileSize - 1) / kTileSize; }
    size_t TileBytes() const { return size_t(kTileSize) * kTileSize * format_.TexelBytes(); }
    /// Of a level's first tile; the others follow row by row.
    uint64_t TilesBegin(int level) const { return tilesBegin_[size_t(level)]; }
    uint64_t FileBytes() const { return fileBytes_; }
    /// All bytes before the first tile: the header and the directories of the levels.
    std::vector<uint8_t> Head() const;

  private:
    std::vector<uint8_t> Directory(int level) const;
    std::vector<Int2> levels_;
    TexelFormat format_;
    std::string description_;
    std::vector<uint64_t> directoryBegin_, tilesBegin_;
    uint64_t fileBytes_ = 0;
};

/// Writes the pyramid of an image to `path`, as an OutputFile.
/// Memory: 64 rows. Errors: FileError about `path` if it cannot be written, and those of the source.
void WriteTiledFile(const std::string& path, const TiledLayout& layout, PyramidSource& source, WrapMode wrap);

/// Whether everything but the texels of such a file is as it was written.
bool HasWholeHead(const std::string& path);

}  // namespace lacquer
